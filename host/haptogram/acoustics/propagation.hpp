// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/model/array.hpp"

namespace haptogram {

/// Amplitude of the circular piston's far field against angle, 2·J1(ka·sin θ)/(ka·sin θ), 1 on the axis (Haptogram eq.
/// 9).
/// @param ka_sin  k·a·sin θ
[[nodiscard]] double piston_directivity(double ka_sin);

/// How a wave goes from one element, facing +z, to a point: pressure at `point` in Pa for a source of 1 Pa·m and phase
/// 0, in the convention e^{jωt}: D(θ)/R · e^{−jkR} (Haptogram eq. 6 and 9). A radius of 0 is a point source.
/// @param k         wave number, rad/m
/// @param radius_m  piston radius
/// @throws Error{bad_input} when the point coincides with the element
[[nodiscard]] std::complex<double> propagation(Vec3 element, Vec3 point, double k, double radius_m);

/// Amplitude of a transducer's far field at an angle, over that on its axis; 0 behind it for a measured pattern, which
/// ends at 90°, and linear between the table's angles.
[[nodiscard]] double directivity(const Transducer& transducer, double k, double cosine);

/// How a wave goes from one of the array's elements, which face +z, to a point: its transducer's pattern, and its
/// medium's absorption e^{−αR}.
/// @throws Error{bad_input} when the point coincides with the element
[[nodiscard]] std::complex<double> propagation(const Array& array, Vec3 element, Vec3 point);

/// Same as the first for an element that faces any way.
[[nodiscard]] std::complex<double> propagation(Vec3 element, Vec3 normal, Vec3 point, double k, double radius_m);

/// The array's propagation to many points, to be used with many drives: points × elements, row by row.
[[nodiscard]] std::vector<std::complex<double>> propagation_matrix(const Array& array, std::span<const Vec3> points);

/// Drives that focus on a point with full strength and exact phases: source · e^{+jkR} each.
[[nodiscard]] std::vector<std::complex<double>> ideal_drives(const Array& array, Vec3 focus);

/// Complex pressure at a point, Pa.
/// @param drives  one an element, Pa·m
[[nodiscard]] std::complex<double> pressure(const Array& array, std::span<const std::complex<double>> drives,
                                            Vec3 point);

}  // namespace haptogram
