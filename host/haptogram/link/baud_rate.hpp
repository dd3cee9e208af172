// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace haptogram::link {

/// The rate of a terminal, or of the one whose master this is; 0 when it has none.
[[nodiscard]] std::uint32_t baud_rate(int descriptor);
/// Sets the rate of a terminal, in both directions, to any number of baud (Linux: termios2).
/// @return the rate that the driver made of it; 0 when the system refuses, and then errno says why
[[nodiscard]] std::uint32_t set_baud_rate(int descriptor, std::uint32_t baud);

}  // namespace haptogram::link
