// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/scattering/body.hpp"

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

}  // namespace haptogram::scattering
