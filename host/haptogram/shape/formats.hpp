// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

#include "haptogram/shape/polygons.hpp"
#include "haptogram/shape/shape.hpp"

namespace haptogram {

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
