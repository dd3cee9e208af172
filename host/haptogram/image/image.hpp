// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/boards/interface.hpp"
#include "haptogram/solve/record.hpp"

namespace haptogram {

/// One step of the sequence.
struct SequenceEntry {
    std::uint16_t index = 0;  ///< 0 silence, 1… records
    std::uint16_t dwell = 1;  ///< carrier cycles
    friend bool operator==(const SequenceEntry&, const SequenceEntry&) = default;
};

/// All that a board is loaded with, and what board it was compiled for.
struct Image {
    std::uint32_t channels = 0;
    std::uint32_t clock_hz = 0;
    std::uint32_t timing_bits = 16;
    std::uint32_t pulse_bits = 8;
    std::vector<Record> records;  ///< record i of the paper is records[i − 1]
    std::vector<SequenceEntry> sequence;
    std::uint16_t loops = 0;  ///< 0 plays for ever
    friend bool operator==(const Image&, const Image&) = default;
};

[[nodiscard]] constexpr std::uint32_t record_words(std::uint32_t channels) {
    return channels + interface::record_header_words;
}

/// Primary memory's contents, records one after the other.
[[nodiscard]] std::vector<std::uint16_t> primary_words(const Image& image);
/// Sequence memory's contents: the header, then the entries.
[[nodiscard]] std::vector<std::uint32_t> sequence_words(const Image& image);

/// The inverse of both: fills `image`, whose channels are known, with what the memories hold.
/// @throws Error{bad_input} naming the record whose words cannot be one
void take_words(Image& image, const std::vector<std::uint16_t>& primary, const std::vector<std::uint32_t>& sequence,
                const std::string& where);

/// The image as Intel HEX: 16-bit words of primary memory, 32-bit words of sequence memory and the description, little-
/// endian, with extended linear addresses.
[[nodiscard]] std::string to_intel_hex(const Image& image);

/// Reads such a file back and checks everything that can be checked without knowing the array.
/// @param where  names the file in messages
/// @throws Error{bad_input} naming the line or the record
[[nodiscard]] Image from_intel_hex(std::string_view text, const std::string& where);

/// What would keep the records and the sequence from being played as they are, in words; empty when nothing does.
[[nodiscard]] std::vector<std::string> problems(const Image& image);

/// @throws Error{bad_input} with the first of the problems, naming the file
void require_playable(const Image& image, const std::string& where);

/// @throws Error{bad_input} saying why a core with these parameters cannot hold or play the image
void require_fits(const Image& image, const interface::CoreParameters& core, const std::string& where);

/// How long each record plays in one pass of the sequence, in clocks.
[[nodiscard]] std::vector<std::uint64_t> record_clocks(const Image& image);

/// `$readmemh` text of primary and sequence memory, one word a line.
[[nodiscard]] std::string primary_readmemh(const Image& image);
[[nodiscard]] std::string sequence_readmemh(const Image& image);

}  // namespace haptogram
