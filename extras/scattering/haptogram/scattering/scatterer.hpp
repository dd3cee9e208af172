// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/scattering/boundary_matrix.hpp"
#include "haptogram/scattering/shells.hpp"

namespace haptogram::scattering {

/// The sound that would be at a body's panels without the body, one value a panel, in the convention e^{jωt}.
struct IncidentSound {
    std::vector<std::complex<float>> pressure;  ///< Pa
    std::vector<std::complex<float>> slope;     ///< along the panel's normal, Pa/m
};

/// What an array sends. Errors as pressure_at().
[[nodiscard]] IncidentSound incident_from(const Array& array, Drives drives, const Body& body,
                                          const FieldOptions& options = {});
/// A plane wave of 1 Pa with phase 0 at the origin.
/// @param direction  in which it travels, of any length but 0
[[nodiscard]] IncidentSound plane_wave_on(const Body& body, Vec3 direction, double wave_number);
/// A point source of 1 Pa·m: e^{−jkR}/R. It lies outside of the body.
[[nodiscard]] IncidentSound point_source_on(const Body& body, Vec3 source, double wave_number);

/// The scattered pressure at a point outside of the body, Pa: ∫p ∂G/∂n dS (Kirchhoff and Helmholtz), with each panel as
/// one point, so further away than some edges.
/// @param pressure  total, on the panels
[[nodiscard]] std::complex<double> scattered_at(const Body& body, std::span<const std::complex<float>> pressure,
                                                double wave_number, Vec3 point);

/// The same far away: r·e^{jkr} times it as r grows, Pa·m. @param direction  of length 1
[[nodiscard]] std::complex<double> scattered_far(const Body& body, std::span<const std::complex<float>> pressure,
                                                 double wave_number, Vec3 direction);

struct ScatteringOptions {
    /// Of the equation's derivative along the normal, in units of 1/k. 0 leaves it out: then the error is large near
    /// the resonances of the space that the body fills.
    double coupling = 0.25;
    double tolerance = 3e-4;  ///< of the residual, over the length of the right-hand side; far below the mesh's error
    std::size_t most_rounds = 200;
};

/// Total sound pressures on a body's panels, and how they were found.
struct SurfacePressures {
    std::vector<std::vector<std::complex<float>>> pressure;  ///< Pa, one list an incident sound, one value a panel
    std::size_t rounds = 0;                                  ///< of the iteration, the most of all; 0 without one
    double residual = 0.0;  ///< relative: the largest of all; of a factorised matrix, that of a side of ones
};

/// A rigid body in air at one frequency: the total pressure on its skin for any sound that comes in, by boundary
/// elements (boundary_matrix.hpp). It is made once a body; then each sound costs some products with its matrix, or,
/// after factorise(), about two.
class Scatterer {
public:
    /// @throws Error{bad_input} when the body has more panels than a matrix can have
    Scatterer(const Body& body, double wave_number, const ScatteringOptions& options = {});

    /// Takes the matrix apart, which costs as much as some dozens of sounds by iteration, for bodies of few panels
    /// less.
    void factorise();
    [[nodiscard]] bool factorised() const { return factors_.has_value(); }
    /// From how many sounds on factorise() saves time.
    [[nodiscard]] std::size_t worth_factorising() const;

    /// @throws Error{failed} when the iteration does not arrive
    [[nodiscard]] SurfacePressures pressures(std::span<const IncidentSound> sounds) const;

private:
    ScatteringOptions options_;
    Kernel kernel_;
    DenseMatrix matrix_;  ///< empty once it is factorised
    std::optional<Factors> factors_;
    double factors_residual_ = 0.0;
};

}  // namespace haptogram::scattering
