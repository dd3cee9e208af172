// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace haptogram {

/// A part of the sequence in a device's memory, which something starts.
struct TriggeredPart {
    std::uint16_t first = 1, length = 1;  ///< entries
    std::uint16_t loops = 1;              ///< passes; 0: until another part starts
    bool by_pin = false;                  ///< by the device's trigger input, without the host
    friend bool operator==(const TriggeredPart&, const TriggeredPart&) = default;
};

}  // namespace haptogram
