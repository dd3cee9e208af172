// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/hand/solid.hpp"

namespace haptogram {

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
