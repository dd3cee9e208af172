// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "acoustics/measure.hpp"

namespace haptogram {

/// A rectangle of points: `columns` along u, `rows` along v.
struct Plane {
    std::string u_axis, v_axis;  ///< "x", "y" or "z"
    std::vector<double> u, v;    ///< metres
    Vec3 origin;                 ///< the third coordinate is its fixed value
    [[nodiscard]] Vec3 point(std::size_t column, std::size_t row) const;
};

/// Reads "xy@z=130" (also xz@y, yz@x; millimetres) and lays a square of half-width `extent` around the axis over it,
/// or, where z is one of its axes, from just above the array to twice the extent.
/// @throws Error{usage}
[[nodiscard]] Plane parse_plane(const std::string& text, double extent_m, double step_m);

/// Radiation pressure on skin, Pa, averaged over the records weighted with the cycles each played (Hoshi eq. 1:
/// P = α·p_rms²/(ρc²), α = 2 for total reflection). Row by row: plane.v.size() × plane.u.size().
[[nodiscard]] std::vector<double> mean_radiation_pressure(const Manifest& manifest,
                                                          const std::vector<MeasuredRecord>& records,
                                                          const Plane& plane);

}  // namespace haptogram
