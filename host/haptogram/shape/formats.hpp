// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// A file found sound, spelled so that the importer library cannot misread it, and what the library must find in it.
/// The library itself takes cut files, absent numbers and corners that are no vertices without a word.
struct Checked {
    std::string content;
    std::size_t points = 0;
    std::size_t faces = 0;  ///< when there are faces, `points` need not be what the library counts
};

/// Each reads a whole file of its format strictly.
/// @param file  its name, for messages
/// @throws Error{bad_input} naming the file, the line or record, what was found and what was expected
[[nodiscard]] Checked check_ply(const std::string& content, const std::string& file);
[[nodiscard]] Checked check_obj(const std::string& content, const std::string& file);
[[nodiscard]] Checked check_stl(std::string content, const std::string& file);

/// Reads a checked file with the importer library, in the file's units.
/// @param format  extension without the dot
[[nodiscard]] Piece import_checked(const Checked& checked, const std::string& format, const std::string& file);

/// Reads white-space separated columns x, y, z; further columns, blank lines and what follows a `#` are ignored.
[[nodiscard]] Cloud read_xyz(std::string_view content, const std::string& file);

/// Reads comma-, semicolon- or tab-separated columns, either named in the first row or x, y, z in front.
[[nodiscard]] Cloud read_csv(std::string_view content, const std::string& file);

/// The number whose bytes start at `bytes`.
template <class Number>
[[nodiscard]] Number load_number(const char* bytes, std::endian order) {
    std::array<char, sizeof(Number)> raw{};
    std::memcpy(raw.data(), bytes, raw.size());
    if (order != std::endian::native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<Number>(raw);
}

}  // namespace haptogram
