// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram::intel_hex {

/// Bytes at an address; the address space is 32 bits wide.
struct Segment {
    std::uint32_t address = 0;
    std::vector<std::uint8_t> bytes;
};

/// Writes segments in the given order, 16 bytes a record, an extended linear address record (type 04) wherever the
/// upper half of the address changes, and the end record. Lines end in "\n"; digits are upper case.
[[nodiscard]] std::string write(const std::vector<Segment>& segments);

/// Reads a file into contiguous segments in ascending order. Data (00), end (01), extended segment (02) and extended
/// linear address (04) records are understood; start addresses (03, 05) have no meaning here and are refused.
/// @throws Error{bad_input} naming the line: no ':' at its start, an odd or impossible length, a character that is no
///   hexadecimal digit, a wrong checksum, an unknown type, an address written twice, no end record, text after it
[[nodiscard]] std::vector<Segment> read(std::string_view text, const std::string& where);

}  // namespace haptogram::intel_hex
