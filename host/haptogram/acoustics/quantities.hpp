// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <functional>
#include <span>

#include "haptogram/array/array.hpp"

namespace haptogram {

// All pressures here are complex amplitudes (peak values, not rms) in Pa, in the convention e^{jωt}.

/// The factor α = 1 + R² of the radiation pressure (Hoshi eq. 1), where R² is the energy that the surface reflects.
/// Skin in air has R² = 0.999 (Hoshi eq. 2), so α = 1.999. Hoshi's numbers use 2, which is 0.05 % more, and so do the
/// functions below unless they are given another α.
inline constexpr double skin_reflection = 1.999;
inline constexpr double total_reflection = 2.0;

/// R², the part of the energy that a boundary between two media reflects: ((Z₂ − Z₁)/(Z₂ + Z₁))² (Hoshi eq. 2).
/// Impedances in N·s/m³.
[[nodiscard]] double reflected_energy(double impedance_1, double impedance_2);

/// Sound pressure level in dB re 20 µPa: 20·lg(|p|/√2/20 µPa). Silence is −∞.
[[nodiscard]] double sound_level_db(std::complex<double> pressure);

/// Time-averaged radiation pressure on a surface at right angles to the wave, Pa: α·p_rms²/(ρc²) (Hoshi eq. 1).
[[nodiscard]] double radiation_pressure(std::complex<double> pressure, const Medium& medium,
                                        double alpha = total_reflection);

/// Diameter of the focal point of a square array of side D at the focal length r, between the main lobe's zeros,
/// metres: w_f = 2λr/D (Hoshi section 2.2).
[[nodiscard]] double focal_diameter(double wavelength_m, double focal_length_m, double side_m);
/// The focal point's depth along the axis, metres: w_d = 2·r·w_f/D (Hoshi section 2.2).
[[nodiscard]] double focal_depth(double wavelength_m, double focal_length_m, double side_m);

/// Force of the radiation pressure on a square parallel to the xy plane, N (Hoshi eq. 5). The square is divided into
/// panels; on each the pressure is integrated by Gauss-Legendre quadrature with five points in each direction.
/// @param pressure  complex pressure as a function of the point
/// @param panel_m   largest width of a panel; with half a wavelength the force of a focused field is off by less than
/// 1e-6
[[nodiscard]] double force_through_square(const std::function<std::complex<double>(Vec3)>& pressure,
                                          const Medium& medium, Vec3 centre, double side_m, double panel_m,
                                          double alpha = total_reflection);

/// The same for the field of an array, with panels of at most half a wavelength.
/// @param drives  one an element, Pa·m
[[nodiscard]] double force_through_square(const Array& array, std::span<const std::complex<double>> drives, Vec3 centre,
                                          double side_m, double alpha = total_reflection);

struct ComplexVec3 {
    std::complex<double> x, y, z;
};

/// Gradient of the complex pressure, Pa/m: the exact derivative of what pressure() computes, with directivity and
/// absorption. A measured pattern may have a kink on an element's axis; there its slope counts as 0.
/// @throws Error{bad_input} when the point coincides with an element
[[nodiscard]] ComplexVec3 pressure_gradient(const Array& array, std::span<const std::complex<double>> drives,
                                            Vec3 point);

/// Complex particle velocity, m/s, by Euler's equation jωρ·v = −∇p: v = j∇p/(ωρ).
[[nodiscard]] ComplexVec3 particle_velocity(const Array& array, std::span<const std::complex<double>> drives,
                                            Vec3 point);

/// Time-averaged sound intensity, W/m²: ½·Re(p·v*).
[[nodiscard]] Vec3 intensity(const Array& array, std::span<const std::complex<double>> drives, Vec3 point);

}  // namespace haptogram
