// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include "haptogram/image/image.hpp"
#include "port.hpp"

namespace haptogram::cli {

/// What became of a stream of indices.
struct Fed {
    std::uint64_t sent = 0;
    std::uint16_t underruns = 0;
    bool interrupted = false;
};

/// Turns the outputs on and plays entries through the live FIFO, no faster than the board takes them, until they end or
/// an interrupt; then off again.
/// @param next   the next entry, waiting at most so many milliseconds for it; empty when there is none yet
/// @param ended  whether none will come
Fed feed(Device& device, std::uint16_t watchdog_ms, const std::function<std::optional<SequenceEntry>(int)>& next,
         const std::function<bool()>& ended);

/// Prints it.
void tell(const Fed& fed, bool json);

/// The carrier frequency of a record in the board's memory. @throws Error{device} when it holds none that can be played
[[nodiscard]] double record_carrier_hz(Device& device, std::uint16_t index);

/// Carrier cycles that make a rate. @throws Error{bad_argument} when no number from 1 to 65535 does within 5 %
[[nodiscard]] std::uint16_t dwell_of(double rate_hz, double carrier_hz);

}  // namespace haptogram::cli
