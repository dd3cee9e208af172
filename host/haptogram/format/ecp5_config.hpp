// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram {

/// Changes the contents of a memory in a placed ECP5 design. Project Trellis has a program for this, ecpbram, but it
/// does not find memories that Yosys has cut into block RAMs of other widths than it expects.
///
/// A block RAM is 2048 rows of 9 bits. In 9-bit mode word i is row i, in 18-bit mode word j is rows 2j (bits 0 to 8)
/// and 2j + 1 (bits 9 to 17), in 36-bit mode a word is four rows. In 4-, 2- and 1-bit mode a row has two, four or eight
/// words. A slice is one bit of those words of the memory that share a block RAM: at most 2048 words, which follow each
/// other or are every second, fourth or eighth. In the configuration, a slice is one column of a block RAM: all its
/// rows, or every second or every fourth. Which column holds which slice is found by comparing their contents with
/// `from`.
///
/// @param config  text configuration of Project Trellis, as nextpnr-ecp5 writes it: every initialised block RAM is a
///                section ".bram_init N" of 256 lines with eight words of three hex digits
/// @param from    what the memory was built with: random words, so that no two slices are alike
/// @param to      as many words
/// @param width   bits of a word, at most 32; those above are ignored
/// @param where   names the configuration in messages
/// @return the configuration with the memory's bits changed, and every other byte as it was
/// @throws Error{failed} when a slice of `from` that has a one is not found exactly once, when slices are found in
/// different modes, or when `to` has a one in a slice of which `from` has only zeros, as such a slice cannot be found;
/// Error{bad_input} for a section of another form; std::invalid_argument for a width or lengths that make no sense
[[nodiscard]] std::string replace_block_ram(std::string_view config, const std::vector<std::uint32_t>& from,
                                            const std::vector<std::uint32_t>& to, unsigned width,
                                            const std::string& where);

/// Changes the delay of each input of a network's receiver, of which there are five: four of data, one of control.
/// @param from, to  in steps of 25 ps, 0 to 127
/// @throws Error{failed} unless the configuration has just these five delays of `from`
[[nodiscard]] std::string replace_rx_delay(std::string config, unsigned from, unsigned to, const std::string& where);

}  // namespace haptogram
