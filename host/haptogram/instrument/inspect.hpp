// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/image/image.hpp"

namespace haptogram {

/// The timings of the channels of a record that fire at all.
struct TimingRange {
    std::uint32_t lowest = 0, highest = 0;  ///< ticks
    std::uint32_t firing = 0;               ///< channels
};

/// What an image holds, record by record, and what would keep it from being played.
struct Inspection {
    Image image;
    std::vector<TimingRange> ranges;    ///< one a record
    std::vector<std::string> problems;  ///< empty when it plays as it is
};

/// @param where  names the image in messages
[[nodiscard]] Inspection inspect(std::string_view hex, const std::string& where);

}  // namespace haptogram
