// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// What a property means for the shape.
enum class PlyRole { none, x, y, z, face, strips };

struct PlyProperty {
    std::string name;
    PlyType type{};
    std::optional<PlyType> count_type{};  ///< set when the property is a list
    PlyRole role = PlyRole::none;
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
};

/// What stands before the data of a PLY file.
struct PlyHeader {
    std::optional<std::endian> binary;  ///< byte order; nothing when the data are text
    std::vector<PlyElement> elements;   ///< in the order of the data
    std::size_t vertices = 0;           ///< how many the data hold
    char line_end = '\n';
    std::size_t lines = 0;
    std::size_t bytes = 0;
};

/// Reads the header and finds the properties that make the shape: x, y and z of `vertex`, and the list
/// `vertex_indices` or `vertex_index` of `face` and `tristrips`.
/// @throws Error{bad_input} naming the file, and the line that does not belong to a PLY header, or the property that is
///         absent or there twice
[[nodiscard]] PlyHeader parse_ply_header(std::string_view content, const std::string& name);

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

// Each of these reads a whole file of one format, to its last byte, in the file's unit.
// `name` is what messages call the file.
// They throw Error{bad_input} that names the file, the line or record, what was found and what was expected.

[[nodiscard]] Polygons read_ply(std::string_view content, const std::string& name);
[[nodiscard]] Polygons read_obj(std::string_view content, const std::string& name);
[[nodiscard]] Polygons read_stl(std::string_view content, const std::string& name);

/// Columns x, y, z, separated by white space. Further columns, blank lines and what follows a `#` are ignored.
[[nodiscard]] Cloud read_xyz(std::string_view content, const std::string& name);

/// Columns separated by commas, semicolons or tabs. Either the first row names x, y and z, or they come first.
[[nodiscard]] Cloud read_csv(std::string_view content, const std::string& name);

/// The number whose bytes start at `bytes`.
template <class Number>
[[nodiscard]] Number load_number(const char* bytes, std::endian order) {
    std::array<char, sizeof(Number)> raw{};
    std::memcpy(raw.data(), bytes, raw.size());
    if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<Number>(raw);
}

}  // namespace haptogram
