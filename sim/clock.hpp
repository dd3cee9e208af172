// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <limits>

#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// A rising edge of the board's clock, counted from the first one of the simulation.
using Clock = std::uint64_t;
inline constexpr Clock never = std::numeric_limits<Clock>::max();

/// Clocks of a carrier period of 40 kHz.
constexpr std::uint32_t carrier_period(const interface::CoreParameters& p) { return p.clock_hz / 40'000; }

}  // namespace haptogram::sim
