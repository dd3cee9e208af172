// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

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

/// Signed distances of a solid on a lattice around it. A distance changes by no more than the way between two places,
/// so the nearest place of the lattice bounds it everywhere, in a fraction of the time.
class DistanceGrid {
public:
    /// @param low, high  corners of a box around the solid, metres
    /// @param distance   the signed distance, negative inside
    DistanceGrid(Vec3 low, Vec3 high, const std::function<double(Vec3)>& distance);

    /// Of a finite place: a number with the sign of the distance at `p`, and no farther from 0; 0 where the lattice
    /// does not tell.
    [[nodiscard]] double bound(Vec3 p) const;

private:
    [[nodiscard]] Vec3 place(std::size_t i, std::size_t j, std::size_t k) const;

    Vec3 low_, high_;
    double step_;
    std::array<std::size_t, 3> count_;
    std::vector<float> distances_;  ///< x runs fastest
};

/// For each vertex the first one at exactly the same place. Files such as STL repeat a vertex for every triangle.
[[nodiscard]] std::vector<std::uint32_t> welded(std::span<const Vec3> vertices);

/// The solid inside a closed surface of triangles. The distance is exact: a tree of boxes finds the nearest triangle,
/// and the normal of its nearest face, edge or corner tells the side (Bærentzen and Aanæs 2005). Vertices at exactly
/// the same place count as one, and triangles with two corners at one place are left out.
/// @param vertices   metres
/// @param triangles  of vertices, anticlockwise when seen from outside
/// @throws Error{bad_input} when an edge has not just two triangles, one in either direction, when a coordinate is not
/// finite, when another triangle has no area, when there is no volume, or when the faces look inwards
[[nodiscard]] Solid mesh_solid(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace haptogram
