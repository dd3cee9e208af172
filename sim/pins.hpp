// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/format/bundle.hpp"

namespace haptogram::sim {

/// What the pins of the Verilated core made of one record.
struct RecordAtPins {
    std::uint64_t cycles = 0;  ///< that it played; 0: not at all
    double full_share = 0.0;   ///< pressure at its first focus by the pins' pulses, over that of full drive
};

/// What they made of an image in one pass.
struct ImageAtPins {
    double burst_hz = 0.0;  ///< how often bursts of pulses come; 0 when there are not two
    std::vector<RecordAtPins> records;
    std::size_t pulses = 0;               ///< that were compared with the image, clock by clock
    std::vector<std::string> violations;  ///< of the core's contracts
};

/// Plays an image, loaded straight into the memories, and measures the pins.
/// @throws Error{bad_input} when the image would not play, or no Verilated core can play it
[[nodiscard]] ImageAtPins measure_pins(const Bundle& bundle);

}  // namespace haptogram::sim
