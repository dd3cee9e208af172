// SPDX-License-Identifier: Apache-2.0
// This is a file of its own because the kernel's termios, which takes any rate, and the C library's cannot both be
// included in one.
#include <asm/termbits.h>
#include <sys/ioctl.h>

#include "haptogram/link/serial_line.hpp"

namespace haptogram::link {

std::uint32_t baud_rate(SerialHandle port) {
    termios2 settings{};
    return ::ioctl(port, TCGETS2, &settings) == 0 ? settings.c_ospeed : 0;
}

std::uint32_t set_baud_rate(SerialHandle port, std::uint32_t baud) {
    termios2 settings{};
    if (::ioctl(port, TCGETS2, &settings) != 0) return 0;
    settings.c_cflag &= ~static_cast<tcflag_t>(CBAUD | CBAUD << IBSHIFT);
    settings.c_cflag |= BOTHER | BOTHER << IBSHIFT;
    settings.c_ispeed = baud;
    settings.c_ospeed = baud;
    if (::ioctl(port, TCSETS2, &settings) != 0 || ::ioctl(port, TCGETS2, &settings) != 0) return 0;
    return settings.c_ospeed;
}

}  // namespace haptogram::link
