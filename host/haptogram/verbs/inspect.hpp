// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/format/image.hpp"

namespace haptogram {

/// The channels of a record that fire at all: their timings, and how long their pulses are.
struct TimingRange {
    std::uint32_t lowest = 0, highest = 0;    ///< ticks, in which the pulses start
    std::uint32_t firing = 0;                 ///< channels
    std::uint32_t shortest = 0, longest = 0;  ///< ticks, of the pulses; without modulation
};

/// What an image holds, record by record, and what would keep it from being played.
struct Inspection {
    Image image;
    std::vector<TimingRange> ranges;    ///< one a record, in the order of places (format/image.hpp); of foci, what the
                                        ///< board computes; nothing fires in a record that would not be played
    std::vector<std::string> problems;  ///< empty when it plays as it is
};

/// @param where  names the image in messages
[[nodiscard]] Inspection inspect(std::string_view hex, const std::string& where);

}  // namespace haptogram
