// Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file.
// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <chrono>
#include <cstdint>

namespace haptogram::link {

/// Those of all configurations, in the order in which a board's rate is looked for.
inline constexpr std::array<std::uint32_t, 3> known_rates = {3000000, 1000000, 115200};
inline constexpr std::chrono::milliseconds probe_patience{150};
inline constexpr unsigned probe_rounds = 4;

}  // namespace haptogram::link
