// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/model/array.hpp"

namespace haptogram {

/// Amplitude of the circular piston's far field against angle, 2·J1(ka·sin θ)/(ka·sin θ), 1 on the axis (Haptogram eq.
/// 9).
/// @param ka_sin  k·a·sin θ
[[nodiscard]] double piston_directivity(double ka_sin);

/// A point lies where an element is, and the pressure there is infinite. The one place where this is said.
[[nodiscard]] Error coincidence();

/// The pressure that a circular piston of 1 Pa·m and phase 0 makes at a point in its far field, Pa: D(θ)/R · e^{−jkR},
/// convention e^{jωt} (Haptogram eq. 6 and 9). A radius of 0 is a point source.
/// @param k         wave number, rad/m
/// @param radius_m  piston radius
/// @throws Error{bad_input} when the point coincides with the element
[[nodiscard]] std::complex<double> piston_wave(const Element& element, Vec3 point, double k, double radius_m);

/// Amplitude of a transducer's far field at an angle, over that on its axis; 0 behind it for a measured pattern, which
/// ends at 90°, and linear between the table's angles.
[[nodiscard]] double directivity(const Transducer& transducer, double k, double cosine);

/// How a wave goes from one of the array's elements to a point: its transducer's pattern around its normal, the
/// distance, and its medium's absorption, D(θ)/R · e^{−αR} · e^{−jkR}. The source strength is the drive's.
/// @throws Error{bad_input} when the point coincides with the element
[[nodiscard]] std::complex<double> propagation(const Array& array, const Element& element, Vec3 point);

/// The array's propagation to many points, to be used with many drives: points × elements, row by row.
[[nodiscard]] std::vector<std::complex<double>> propagation_matrix(const Array& array, std::span<const Vec3> points);

/// Drives that focus on a point with full strength and exact phases: source · e^{+jkR} each.
[[nodiscard]] std::vector<std::complex<double>> ideal_drives(const Array& array, Vec3 focus);

/// Complex pressure at a point, Pa.
/// @param drives  one an element, Pa·m
[[nodiscard]] std::complex<double> pressure(const Array& array, std::span<const std::complex<double>> drives,
                                            Vec3 point);

}  // namespace haptogram
