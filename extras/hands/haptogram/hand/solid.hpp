// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// A solid as its signed distance: to the nearest point of its surface, metres, negative inside. The distances are
/// exact everywhere, not only near the surface.
struct Solid {
    std::function<double(Vec3)> distance;
    /// Where the distance takes long, a quick number with its sign and no farther from 0, or 0; else empty.
    std::function<double(Vec3)> bound{};
    [[nodiscard]] bool contains(Vec3 point) const { return distance(point) < 0.0; }
};

// Every function throws Error{bad_argument} naming a measure that is not positive and finite. Solids stand along z.

[[nodiscard]] Solid solid_sphere(Vec3 centre, double radius);
/// @param edges  along x, y and z
[[nodiscard]] Solid solid_box(Vec3 centre, Vec3 edges);
/// All that lies behind a plane. @param normal  out of it, any length but 0
[[nodiscard]] Solid half_space(Vec3 point, Vec3 normal);
/// @param centre  of the whole cylinder
[[nodiscard]] Solid solid_cylinder(Vec3 centre, double radius, double height);
/// @param base  centre of the base; the tip is `height` above it
[[nodiscard]] Solid solid_cone(Vec3 base, double radius, double height);
/// @param base  centre of the square base, whose edges are along x and y; the tip is `height` above it
[[nodiscard]] Solid solid_pyramid(Vec3 base, double edge, double height);

/// A solid in another place: turned by degrees about x, then y, then z, through the origin, then moved.
[[nodiscard]] Solid moved(const Solid& solid, Vec3 shift, Vec3 angles_deg = {});

}  // namespace haptogram
