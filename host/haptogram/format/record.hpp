// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "haptogram/format/interface.hpp"

namespace haptogram {

/// What every channel of the core does in one carrier period, as the FPGA stores it (rtl/INTERFACE.md).
struct Record {
    std::uint32_t cycle_length = 0;      ///< ticks, 24 bits
    std::uint32_t prescaler = 1;         ///< clocks per tick, 24 bits
    std::uint8_t pulse_length = 0;       ///< ticks
    std::vector<std::uint16_t> timings;  ///< one a channel; interface::silent_timing never fires. Of amplitudes: their
                                         ///< words as interface::Kind says, and prescaler 1 and pulse length 0
    interface::Kind kind = interface::Kind::timings;

    /// Whether a channel fires at all.
    [[nodiscard]] bool fires(std::size_t channel) const {
        if (kind == interface::Kind::amplitudes) return timings[channel] >> 8U != 0;
        return pulse_length > 0 && timings[channel] < cycle_length && timings[channel] != interface::silent_timing;
    }
    friend bool operator==(const Record&, const Record&) = default;
};

}  // namespace haptogram
