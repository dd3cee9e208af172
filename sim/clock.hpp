// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <limits>

namespace haptogram::sim {

/// A rising edge of the board's clock, counted from the first one of the simulation.
using Clock = std::uint64_t;
inline constexpr Clock never = std::numeric_limits<Clock>::max();

}  // namespace haptogram::sim
