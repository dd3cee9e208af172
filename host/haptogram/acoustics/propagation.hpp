// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {

/// A transducer's directivity in a form that is fast to compute with vector instructions.
struct FittedPattern {
    enum class Kind { point, polynomial, table } kind = Kind::point;
    /// Of a polynomial: coefficients of the powers of 2·cos²θ − 1, lowest first. Of a table: amplitudes at evenly
    /// spaced angles from 0 to 90°.
    std::vector<float> values;
    bool behind = true;  ///< an element radiates backwards as it does forwards; otherwise not at all
    double error = 0.0;  ///< largest difference from a measured pattern, of the amplitude on the axis
};

/// The degrees that a polynomial may have. There are few, so that the loops can be unrolled for each of them.
inline constexpr std::size_t polynomial_degrees[] = {5, 8, 14};

/// Fits the pattern with an error of at most 2e-6 of the amplitude on the axis. Pistons that are many wavelengths wide
/// become tables. A measured pattern stays a table, unless a polynomial of degree 5 or 8 differs from the table's
/// straight lines by at most `measured_error`: a table that is measured to 1 dB at its ends is fitted to 0.1 dB by
/// degree 5.
/// @param k               wave number, rad/m
/// @param measured_error  of the amplitude on the axis
[[nodiscard]] FittedPattern fit_pattern(const Transducer& transducer, double k, double measured_error = 0.0);

/// Directivity of a circular piston in its far field, 2·J1(ka·sin θ)/(ka·sin θ), which is 1 on the axis (Haptogram eq.
/// 9).
/// @param ka_sin  k·a·sin θ
[[nodiscard]] double piston_directivity(double ka_sin);

/// The error of every field function for a point at the position of an element, where the pressure would be infinite.
[[nodiscard]] Error coincidence();

/// The pressure that a circular piston of 1 Pa·m and phase 0 makes at a point in its far field, Pa: D(θ)/R · e^{−jkR},
/// convention e^{jωt} (Haptogram eq. 6 and 9). A radius of 0 is a point source.
/// @param k         wave number, rad/m
/// @param radius_m  piston radius
/// @throws Error{bad_input} when the point coincides with the element
[[nodiscard]] std::complex<double> piston_wave(const Element& element, Vec3 point, double k, double radius_m);

/// Directivity of a transducer: its far field's amplitude at an angle to its axis, over that on the axis. A measured
/// pattern is linear between the angles of its table; it ends at 90°, and behind the transducer it is 0.
/// @param k       wave number, rad/m
/// @param cosine  of the angle
[[nodiscard]] double directivity(const Transducer& transducer, double k, double cosine);

/// Pressure at a point that one of the array's elements makes with a drive of 1 Pa·m, 1/m: g · D(θ)/R · e^{−αR} ·
/// e^{−jkR}. g is the element's response, D the transducer's directivity, θ the angle to the element's normal, R the
/// distance and α the medium's absorption.
/// @throws Error{bad_input} when the point coincides with the element
[[nodiscard]] std::complex<double> propagation(const Array& array, const Element& element, Vec3 point);

/// The array's propagation to many points, one row a point and one column an element. It is worth its memory when many
/// drives are to be summed at the same points.
[[nodiscard]] std::vector<std::complex<double>> propagation_matrix(const Array& array, std::span<const Vec3> points);

/// Drives that focus on a point with full strength and exact phases: source strength · e^{+jkR} for each element, less
/// the phase of its response; 0 of a dead one.
[[nodiscard]] std::vector<std::complex<double>> ideal_drives(const Array& array, Vec3 focus);

/// Full width at half maximum of the radiation pressure through a focus of exact phases, along x, metres.
[[nodiscard]] double focal_width(const Array& array, Vec3 focus);

/// Complex pressure at a point, Pa: the sum over the elements of drive · propagation, in double precision.
/// @param drives  one an element, Pa·m
[[nodiscard]] std::complex<double> pressure(const Array& array, std::span<const std::complex<double>> drives,
                                            Vec3 point);

}  // namespace haptogram
