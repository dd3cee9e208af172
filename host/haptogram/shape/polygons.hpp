// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// What a mesh file holds, in the file's unit: vertices, and faces of three or more corners.
struct Polygons {
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> corners;  ///< indices into `vertices`, one face after another
    std::vector<std::size_t> face_ends;  ///< for each face, where in `corners` the next one begins

    /// Ends the face whose corners were added last.
    void end_face() { face_ends.push_back(corners.size()); }
    void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        corners.insert(corners.end(), {a, b, c});
        end_face();
    }
};

/// A mesh, its faces cut into triangles; or the vertices as a cloud when there are no faces.
/// A face of n corners becomes n - 2 triangles, also when it is concave.
/// @param name  of the file, for messages
/// @throws Error{bad_input} for no vertices, for faces that have no area, and for a face that crosses itself
[[nodiscard]] Piece as_piece(Polygons polygons, const std::string& name);

}  // namespace haptogram
