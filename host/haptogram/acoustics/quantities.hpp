// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <functional>
#include <span>

#include "haptogram/model/array.hpp"

namespace haptogram {

// Pressures are complex amplitudes (peak, not rms) in Pa, convention e^{jωt}.

/// α = 1 + R² of Hoshi eq. 1. Skin in air has R² = 0.999 (eq. 2), so α = 1.999; Hoshi's numbers, and everything here
/// unless told otherwise, use 2, which is 0.05 % more.
inline constexpr double skin_reflection = 1.999;
inline constexpr double total_reflection = 2.0;

/// R² of Hoshi eq. 2, the energy that a boundary between two media reflects: ((Z₂ − Z₁)/(Z₂ + Z₁))², impedances in
/// N·s/m³.
[[nodiscard]] double reflected_energy(double impedance_1, double impedance_2);

/// Sound pressure level, dB re 20 µPa: 20·lg(|p|/√2/20 µPa). −∞ for silence.
[[nodiscard]] double sound_level_db(std::complex<double> pressure);

/// Radiation pressure on a surface that the wave meets head-on, Pa: α·p_rms²/(ρc²) (Hoshi eq. 1).
[[nodiscard]] double radiation_pressure(std::complex<double> pressure, const Medium& medium,
                                        double alpha = total_reflection);

/// Diameter w_f = 2λr/(Nd) of the focal point of a square array of side Nd, between the main lobe's zeros, metres, and
/// its depth w_d = 2·r·w_f/(Nd) (Hoshi 2.2).
[[nodiscard]] double focal_diameter(double wavelength_m, double focal_length_m, double side_m);
[[nodiscard]] double focal_depth(double wavelength_m, double focal_length_m, double side_m);

/// Force of the radiation pressure through a square parallel to the array, N (Hoshi eq. 5), by Gauss-Legendre
/// quadrature of five points a panel in each direction.
/// @param pressure  at a point, Pa
/// @param panel_m   the widest a panel may be; half a wavelength leaves less than 1e-6 of a focused field's force out
[[nodiscard]] double force_through_square(const std::function<std::complex<double>(Vec3)>& pressure,
                                          const Medium& medium, Vec3 centre, double side_m, double panel_m,
                                          double alpha = total_reflection);

/// The same for an array's field, with panels of half a wavelength at most.
/// @param drives  one an element, Pa·m
[[nodiscard]] double force_through_square(const Array& array, std::span<const std::complex<double>> drives, Vec3 centre,
                                          double side_m, double alpha = total_reflection);

struct ComplexVec3 {
    std::complex<double> x, y, z;
};

/// ∇p in Pa/m, term by term of the sum over the elements: exact for what pressure() computes, with the directivity's
/// slope and the absorption. On an element's axis, where a measured pattern may have an edge, its slope counts as 0.
/// @throws Error{bad_input} when the point coincides with an element
[[nodiscard]] ComplexVec3 pressure_gradient(const Array& array, std::span<const std::complex<double>> drives,
                                            Vec3 point);

/// Particle velocity, m/s: Euler's equation jωρ·v = −∇p, so v = j∇p/(ωρ).
[[nodiscard]] ComplexVec3 particle_velocity(const Array& array, std::span<const std::complex<double>> drives,
                                            Vec3 point);

/// Time-averaged sound intensity, W/m²: ½·Re(p·v*).
[[nodiscard]] Vec3 intensity(const Array& array, std::span<const std::complex<double>> drives, Vec3 point);

}  // namespace haptogram
