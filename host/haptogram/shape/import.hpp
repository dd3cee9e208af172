// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "haptogram/shape/readers.hpp"
#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// Whether a file's name ends as that of a shape does.
[[nodiscard]] bool has_shape_ending(const std::string& file_name);

/// The format that a file's name tells by its extension, in any case.
/// @throws Error{bad_input} for any other extension, naming those that are known
[[nodiscard]] ShapeFormat shape_format(const std::string& file_name);

/// The format that the content tells, for what has no name of its own, such as standard input.
/// @throws Error{bad_input} for content that is of none, naming `name`
[[nodiscard]] ShapeFormat shape_format(std::string_view content, const std::string& name);

/// @return whether a comment of an OBJ file names a program that writes such files with y upwards
[[nodiscard]] bool has_y_up_by_habit(std::string_view obj);

/// The shape of a file with y upwards, standing: x, y, z become x, -z, y.
[[nodiscard]] Shape stood_up(Shape shape);

/// Reads a shape from memory, for example one that a browser sent. Files with faces become one Mesh: several objects
/// are joined and polygons are cut into triangles; Mesh::flaw tells of polygons that cross themselves. Files with lines
/// and no faces become a Curve each; others one Cloud. Numbers keep double precision.
/// @param readers          of the formats that the core does not read
/// @param metres_per_unit  what a 1 in the file means, for example 1e-3; positive and finite
/// @throws Error{bad_input} naming the shape and the line or record, for content that is empty, cut short or garbled,
///         has no points, a coordinate that is not finite, a corner that is no vertex, or faces without area
/// @throws Error{bad_argument} for a `metres_per_unit` that makes no sense, and for a format without a reader
[[nodiscard]] Shape load_shape(const ShapeFile& file, ShapeFormat format, double metres_per_unit,
                               const ShapeReaders& readers = {});

/// Reads a shape file; its extension tells the format, and its path is its name in messages.
/// @throws Error{bad_input} for a path that cannot be read, too
[[nodiscard]] Shape load_shape(const std::filesystem::path& path, double metres_per_unit,
                               const ShapeReaders& readers = {});

}  // namespace haptogram
