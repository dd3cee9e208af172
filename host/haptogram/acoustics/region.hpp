// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/array/rig.hpp"
#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// Points on straight axes, metres: a line, a plane or a volume has one, two or three axes of more than one coordinate.
/// Points are numbered with x fastest and z slowest.
struct Grid {
    std::vector<double> x, y, z;

    [[nodiscard]] std::size_t size() const { return x.size() * y.size() * z.size(); }
    [[nodiscard]] Vec3 point(std::size_t i) const {
        return {x[i % x.size()], y[i / x.size() % y.size()], z[i / (x.size() * y.size())]};
    }
};

/// The points at which a field is wanted: a line, a plane or a volume along the axes, or an oblique plane.
struct Region {
    Grid grid;         ///< of an oblique plane in its own coordinates: u in x, v in y, and z is 0
    std::string axes;  ///< those along which the points spread, in this order: "x", "xz", "xyz", …; "uv" if oblique
    std::string text;  ///< as it was asked for, such as "xy@z=130"
    std::optional<Pose> pose;  ///< of an oblique plane

    /// A point of the grid in the array's frame.
    [[nodiscard]] Vec3 point(std::size_t i) const { return pose ? pose->outwards(grid.point(i)) : grid.point(i); }
};

/// The size of a region and the distance between its points, metres. An axis with a range spreads over that range. Any
/// other spreads from −extent to +extent; but z, which begins at the array, from one step to twice the extent. The
/// axes u and v of an oblique plane take the ranges of x and y.
struct Reach {
    double extent_m = 80e-3;
    double step_m = 1e-3;
    std::optional<std::pair<double, double>> x, y, z;
};

/// Reads the text of a region, millimetres: "z@x=0,y=5" is a line, "xy@z=130" a plane, "xyz" the volume. An oblique
/// plane is "uv@", a point of it, and either how it is turned from the xy plane, in degrees about the fixed x, then y,
/// then z axis ("uv@z=130,rx=30"), or its normal, of any length ("uv@z=130,ny=-1,nz=2"), where u lies as near to x as
/// it can. What is not named is 0. The point is the origin of u and v.
/// @param setting  that the text is the value of, for messages
/// @throws Error{bad_argument} naming `setting` when the text is none of these, or has points at or below z = 0; naming
/// "step" when the step does not suit the extent, or the points need more memory than this machine has
[[nodiscard]] Region parse_region(const std::string& setting, const std::string& text, const Reach& reach);

/// Reads a range such as "-40:40", millimetres, and returns it in metres.
/// @throws Error{bad_argument} naming `setting`
[[nodiscard]] std::pair<double, double> parse_range(const std::string& setting, const std::string& text);

}  // namespace haptogram
