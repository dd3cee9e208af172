// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/solve/segments.hpp"

namespace haptogram {

/// The table of a device that cannot compute: for each position that a focus may have, the pulse of each channel. Hoshi
/// et al. 2010 (section 3.1) load it into nine units of 36 channels at power-up; after that a command names a position.
struct PositionTable {
    std::vector<Vec3> positions;       ///< metres
    std::size_t channels = 0;          ///< one an element
    std::vector<SegmentPulse> pulses;  ///< position by position, and in it channel by channel

    [[nodiscard]] const SegmentPulse& at(std::size_t position, std::size_t channel) const {
        return pulses[position * channels + channel];
    }
};

/// Full strength everywhere, and the phases of the focal law (Haptogram eq. 2–5) on the grid of segments.
/// @throws Error{bad_input} naming the first position that the array cannot reach
[[nodiscard]] PositionTable position_table(const Array& array, std::span<const Vec3> positions,
                                           const Segments& segments);

/// The channels of each unit, in the order of the unit's outputs. The paper does not say which channels a unit has;
/// ours are squares of 6 × 6 neighbours, row by row.
/// @throws Error{bad_input} when the array is no grid whose rows and columns are multiples of `edge`
[[nodiscard]] std::vector<std::vector<std::size_t>> square_units(const Array& array, std::size_t edge = 6);

/// A unit's part of the table as its memory holds it: position by position and channel by channel, four bits of phase
/// and three of amplitude, highest bit first, without gaps. The phase is the segment in which the pulse starts. The
/// amplitude is the length in segments less one: three bits hold eight of the nine lengths, and silence is the one that
/// a table of foci can do without.
/// @throws Error{bad_argument} for a grid of other than 16 segments, and for a silent channel
[[nodiscard]] std::vector<std::uint8_t> packed(const PositionTable& table, std::span<const std::size_t> unit,
                                               const Segments& segments);

}  // namespace haptogram
