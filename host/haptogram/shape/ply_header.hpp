// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <bit>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

}  // namespace haptogram
