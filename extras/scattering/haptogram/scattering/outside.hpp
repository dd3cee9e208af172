// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>

#include "haptogram/scattering/body.hpp"

namespace haptogram::scattering {

/// The scattered pressure at a point outside of the body, Pa: ∫p ∂G/∂n dS (Kirchhoff and Helmholtz), with each panel as
/// one point, so further away than some edges.
/// @param pressure  total, on the panels
[[nodiscard]] std::complex<double> scattered_at(const Body& body, std::span<const std::complex<float>> pressure,
                                                double wave_number, Vec3 point);

/// The same far away: r·e^{jkr} times it as r grows, Pa·m. @param direction  of length 1
[[nodiscard]] std::complex<double> scattered_far(const Body& body, std::span<const std::complex<float>> pressure,
                                                 double wave_number, Vec3 direction);

}  // namespace haptogram::scattering
