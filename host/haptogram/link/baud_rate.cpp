// SPDX-License-Identifier: Apache-2.0
// This is a file of its own because the kernel's termios, which takes any rate, and the C library's cannot both be
// included in one.
#include "haptogram/link/baud_rate.hpp"

#include <asm/termbits.h>
#include <sys/ioctl.h>

namespace haptogram::link {

std::uint32_t baud_rate(int descriptor) {
    termios2 settings{};
    return ::ioctl(descriptor, TCGETS2, &settings) == 0 ? settings.c_ospeed : 0;
}

std::uint32_t set_baud_rate(int descriptor, std::uint32_t baud) {
    termios2 settings{};
    if (::ioctl(descriptor, TCGETS2, &settings) != 0) return 0;
    settings.c_cflag &= ~static_cast<tcflag_t>(CBAUD | CBAUD << IBSHIFT);
    settings.c_cflag |= BOTHER | BOTHER << IBSHIFT;
    settings.c_ispeed = baud;
    settings.c_ospeed = baud;
    if (::ioctl(descriptor, TCSETS2, &settings) != 0 || ::ioctl(descriptor, TCGETS2, &settings) != 0) return 0;
    return settings.c_ospeed;
}

}  // namespace haptogram::link
