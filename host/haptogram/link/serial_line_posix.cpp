// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#ifdef __APPLE__
#include <IOKit/serial/ioss.h>
#endif

#include "haptogram/link/serial_line.hpp"

namespace haptogram::link {

bool keep_to_us(SerialHandle port) {
    ::fcntl(port, F_SETFD, FD_CLOEXEC);
    return ::flock(port, LOCK_EX | LOCK_NB) == 0;
}

void forget(SerialHandle port, bool also_received) { ::tcflush(port, also_received ? TCIOFLUSH : TCOFLUSH); }

bool hold_break(SerialHandle port, bool on) { return ::ioctl(port, on ? TIOCSBRK : TIOCCBRK) == 0; }

bool wait_to_write(SerialHandle port, std::chrono::milliseconds patience) {
    pollfd wait{port, POLLOUT, 0};
    return ::poll(&wait, 1, static_cast<int>(patience.count())) > 0;
}

#ifdef __APPLE__
std::uint32_t baud_rate(SerialHandle port) {
    termios settings{};
    return ::tcgetattr(port, &settings) == 0 ? static_cast<std::uint32_t>(::cfgetospeed(&settings)) : 0;
}

std::uint32_t set_baud_rate(SerialHandle port, std::uint32_t baud) {
    speed_t rate = baud;
    return ::ioctl(port, IOSSIOSPEED, &rate) == 0 ? baud : 0;
}
#endif

}  // namespace haptogram::link
