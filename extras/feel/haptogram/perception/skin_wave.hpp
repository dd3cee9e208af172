// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptogram::perception {

/// Skin as a damped membrane on a soft foundation: w'' = c²∇²w − 2γw' − ω₀²w + P/m. It explains why a focus that moves
/// about as fast as waves in the skin is felt best (Frier et al. 2018). The parameters are ours, chosen so that the
/// deflection is largest between 5 and 7 m/s; nobody measured this membrane.
struct SkinMembrane {
    double wave_speed_m_s = 6.0;    ///< c; shear waves in skin travel at 3 to 7 m/s
    double damping_1_s = 300.0;     ///< γ
    double foundation_hz = 60.0;    ///< ω₀/2π
    double focus_width_m = 8.6e-3;  ///< full width at half maximum of the radiation pressure, a Gaussian
};

inline constexpr double fastest_wave_m_s = 12.0;  ///< up to which the model is used

/// The largest deflection under a focus that moves along a straight line at one speed, over that of a focus that rests.
/// In Fourier space W(k) = P(k)/(ω₀² + c²k² − (k·v)² + 2jγ(k·v)); it is summed on a square of 400 mm with 512 × 512
/// points. By symmetry the largest deflection is on the line.
/// @throws Error{bad_argument} naming "speed" outside of 0 to 12 m/s
[[nodiscard]] double deflection_over_static(double speed_m_s, const SkinMembrane& skin = {});

}  // namespace haptogram::perception
