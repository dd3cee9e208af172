// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/acoustics/region.hpp"
#include "haptogram/array/array.hpp"
#include "haptogram/base/progress.hpp"

namespace haptogram {

/// Complex source strengths, one an element, Pa·m.
using Drives = std::span<const std::complex<double>>;

/// Drives that play for a share of the time.
struct WeightedDrives {
    double weight = 1.0;  ///< only the ratios of the weights matter
    Drives drives;
};

/// How a field is computed.
enum class FieldMethod {
    sums,          ///< every element's wave is summed at every point
    shifts,        ///< one element's wave is computed on a lattice, and shifted copies of it are summed (shift.hpp)
    interpolated,  ///< either of these on a coarser grid, and interpolated between its points (coarse.hpp)
};
/// "sums", "shifts" or "interpolated".
[[nodiscard]] const char* name_of(FieldMethod method);

struct FieldOptions {
    /// How many threads may work on this call; 0: one a processor, and never more than that. Calls that run at the same
    /// time do not affect each other's number. The result is the same, byte by byte, for any number.
    unsigned threads = 1;
    Progress progress{};  ///< told from the calling thread; when it ends the work, the call throws Error{cancelled}
    /// What an interpolated field may be off by, of the largest |p| that the drives, with any phases, could make at any
    /// of the points asked. A field that would be off by more is summed at every point. 0: nothing is interpolated.
    double interpolation_error = 1e-4;
    /// What a polynomial may differ by from a measured pattern, of the amplitude on the axis. Where one of low degree
    /// does not, it takes the place of the table's straight lines, which takes a third of the time. 0: always the
    /// table.
    double pattern_error = 0.0;
};

/// Complex pressures, how they were computed, and how far they may be off.
struct PressureField {
    std::vector<std::complex<float>> values;  ///< Pa, in the order of the points asked
    FieldMethod method = FieldMethod::sums;
    /// Of the largest |p| that the drives, with any phases, could make at any of the points asked. Of sums it is the
    /// bound that tests hold them to. Of an interpolated field it is found by summing the waves at 64 of the points.
    double error = 0.0;
    /// Largest difference of the directivity that was used from the transducer's, of the amplitude on the axis.
    double pattern_error = 0.0;
};

/// Complex pressure in Pa, convention e^{jωt}: the sum over the elements of drive · propagation (propagation.hpp), each
/// element radiating around its own normal. Computed in single precision; the error is at most 1e-4 of the largest |p|
/// that the drives, with any phases, could make at any of the points asked.
/// @throws Error{bad_input} when a point coincides with an element, or there is not one drive an element
[[nodiscard]] std::vector<std::complex<float>> pressure_at(const Array& array, Drives drives,
                                                           std::span<const Vec3> points,
                                                           const FieldOptions& options = {});
/// The same on a grid, in the order of Grid::point(), by the quickest method that keeps the error. Interpolation needs
/// grids that are two and a half wavelengths away from all elements. An oblique plane is a grid in the coordinates of
/// the plane's pose: ask for the field of seen_from(array, pose) (array/rig.hpp).
[[nodiscard]] PressureField pressure_field(const Array& array, Drives drives, const Grid& grid,
                                           const FieldOptions& options = {});
/// Its values alone.
[[nodiscard]] std::vector<std::complex<float>> pressure_on(const Array& array, Drives drives, const Grid& grid,
                                                           const FieldOptions& options = {});

/// Gradient of the complex pressure, Pa/m, at any points: the derivative of what pressure_at() computes, with
/// directivity and absorption. The error is at most 1e-4 of k times the largest |p| that the drives, with any phases,
/// could make at any of the points asked. A measured pattern that no polynomial replaces (FieldOptions::pattern_error)
/// is computed in double precision, point by point (quantities.hpp). Errors as above.
struct PressureGradient {
    std::complex<float> x, y, z;
};
[[nodiscard]] std::vector<PressureGradient> pressure_gradient_at(const Array& array, Drives drives,
                                                                 std::span<const Vec3> points,
                                                                 const FieldOptions& options = {});

/// Mean square of the pressure over a sequence of drives, Pa²: Σ weight·|p|²/2 over Σ weight, at any points or on a
/// grid. Zero when nothing plays. Errors as above.
[[nodiscard]] std::vector<float> mean_square_pressure_at(const Array& array, std::span<const WeightedDrives> sequence,
                                                         std::span<const Vec3> points,
                                                         const FieldOptions& options = {});
[[nodiscard]] std::vector<float> mean_square_pressure(const Array& array, std::span<const WeightedDrives> sequence,
                                                      const Grid& grid, const FieldOptions& options = {});

/// Mean squares on a grid, how they were computed, and how far they may be off.
struct MeanSquareField {
    std::vector<float> values;  ///< Pa², in the order of Grid::point()
    FieldMethod method = FieldMethod::sums;
    /// Of the rms pressure, which is the root of a value: of the largest that the drives, with any phases, could make.
    double error = 0.0;
};
/// A sequence in which one set of drives alone plays is computed as pressure_field() does; others by sums.
[[nodiscard]] MeanSquareField mean_square_field(const Array& array, std::span<const WeightedDrives> sequence,
                                                const Grid& grid, const FieldOptions& options = {});
/// What a gradient is held to on a grid: of k times the largest |p|, as pressure_gradient_at() says.
inline constexpr double gradient_error = 1e-4;

}  // namespace haptogram
