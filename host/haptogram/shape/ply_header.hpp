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

struct PlyProperty {
    std::string name;
    PlyType type{};
    std::optional<PlyType> count_type;  ///< set when the property is a list
};

struct PlyElement {
    std::string name;
    std::size_t count = 0;
    std::vector<PlyProperty> properties;
};

/// What stands before the data of a PLY file.
struct PlyHeader {
    std::optional<std::endian> binary;  ///< byte order; none when the data are text
    std::vector<PlyElement> elements;
    std::size_t lines = 0;
    std::size_t bytes = 0;

    /// Number of `name`d elements, 0 when the header does not speak of them.
    [[nodiscard]] std::size_t count(std::string_view name) const;
};

/// @throws Error{bad_input} naming the file and the line that is not of a PLY header with x, y and z of vertices
[[nodiscard]] PlyHeader parse_ply_header(std::string_view content, const std::string& file);

}  // namespace haptogram
