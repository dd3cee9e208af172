// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <filesystem>
#include <fstream>
#include <system_error>
#ifdef __APPLE__
#include <IOKit/serial/ioss.h>
#endif
#ifdef __linux__
#include <linux/serial.h>
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

namespace {

/// Where the kernel says how long an adapter waits; it has none for others.
std::string latency_file(const std::string& path) {
    std::error_code ignored;  // what is no file has no name there either
    return "/sys/class/tty/" + std::filesystem::canonical(path, ignored).filename().string() + "/device/latency_timer";
}

}  // namespace

std::optional<unsigned> latency_ms(const std::string& path) {
    unsigned milliseconds = 0;
    if (std::ifstream(latency_file(path)) >> milliseconds) return milliseconds;
    return {};
}

void ask_for_low_latency([[maybe_unused]] SerialHandle port, const std::string& path) {
#ifdef __linux__
    serial_struct settings{};
    if (::ioctl(port, TIOCGSERIAL, &settings) == 0) {
        settings.flags |= ASYNC_LOW_LATENCY;
        ::ioctl(port, TIOCSSERIAL, &settings);
    }
#endif
    if (latency_ms(path).value_or(1) > 1) std::ofstream(latency_file(path)) << 1;  // where this user may
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
