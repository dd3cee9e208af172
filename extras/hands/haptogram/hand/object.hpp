// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/hand/solid.hpp"

namespace haptogram {

/// An edge of an object, as straight lines from point to point. A closed one ends where it begins.
using Edge = std::vector<Vec3>;

/// What a hand can touch: a solid, and the features by which it is told from others (Shapes, section IV-B).
struct TouchObject {
    std::string name;
    Solid solid;
    std::vector<Edge> edges;    ///< sharp boundaries between two faces, metres
    std::vector<Vec3> corners;  ///< where edges meet, and tips
    Vec3 low, high;             ///< a box around it, for pictures; a half-space has one around its point
};

/// Measures of a built-in object, metres.
struct ObjectMeasures {
    double size = 0.1;           ///< edge of a cube and of a pyramid's base, diameter of all round ones
    double height = 0.1;         ///< of a cone, a pyramid and a cylinder
    Vec3 centre{0.0, 0.0, 0.2};  ///< of the box around it; of a half-space, a point of its surface
    Vec3 angles_deg;             ///< turned about its centre: about x, then y, then z
};

/// A built-in object. It has as features: a cube 12 edges and 8 corners, a square pyramid 8 and 5, a cone its base
/// circle and its tip, a cylinder two circles, a sphere and a half-space none. Circles are polygons of 360 corners.
/// @throws Error{bad_argument} for another kind, naming those that there are, and for measures that are not positive
[[nodiscard]] TouchObject built_in_object(std::string_view kind, const ObjectMeasures& measures);

/// The object inside a closed mesh. Its edges are those where two faces meet at more than an angle, in as long pieces
/// as they have; its corners are where other than two such edges meet.
/// @param sharp_deg  the angle between the faces' normals
/// @throws Error{bad_input} as mesh_solid() does
[[nodiscard]] TouchObject mesh_object(const std::string& name, std::span<const Vec3> vertices,
                                      std::span<const std::array<std::uint32_t, 3>> triangles, double sharp_deg = 30.0);

}  // namespace haptogram
