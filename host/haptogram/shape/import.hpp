// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// Reads a shape file, its format told by the extension in any case: .ply, .obj, .stl, .xyz or .csv. A file with faces
/// becomes one Mesh, several objects in it joined and polygons cut into triangles; a file without becomes one Cloud.
/// PLY, OBJ and STL pass through single precision: 7 significant digits.
/// @param metres_per_unit  what a 1 in the file means, for example 1e-3
/// @param content_sha256   when given, gets the hash of what was read; the file, which may be a pipe, is read once
/// @throws Error{bad_input} naming the file and the line or record, for a file that is missing, empty, cut short or
///         garbled, has no points, a coordinate that is not finite, a corner that is no vertex, or faces without area
[[nodiscard]] Shape load_shape(const std::filesystem::path& path, double metres_per_unit,
                               std::string* content_sha256 = nullptr);

}  // namespace haptogram
