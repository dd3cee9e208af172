// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

namespace haptogram::link {

/// Sets a terminal's rate, both ways, to any number of baud (Linux: termios2), and reads back what the driver made of
/// it.
/// @return the rate that is set now, 0 when the system refuses (errno says why)
[[nodiscard]] std::uint32_t set_baud_rate(int descriptor, std::uint32_t baud);

}  // namespace haptogram::link
