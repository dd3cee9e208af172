// SPDX-License-Identifier: Apache-2.0
#include <windows.h>

#include <cerrno>
#include <system_error>

#include "haptogram/link/serial_line.hpp"

namespace haptogram::link {

bool keep_to_us(SerialHandle) { return true; }  // who opens a port on Windows has it alone

void forget(SerialHandle port, bool also_received) {
    ::PurgeComm(port, PURGE_TXCLEAR | PURGE_TXABORT | (also_received ? PURGE_RXCLEAR : 0));
}

bool hold_break(SerialHandle port, bool on) { return (on ? ::SetCommBreak(port) : ::ClearCommBreak(port)) != 0; }

/// Boost.Asio's writing waits by itself there.
bool wait_to_write(SerialHandle, std::chrono::milliseconds) { return true; }  // its writes wait themselves

std::uint32_t baud_rate(SerialHandle port) {
    DCB settings{};
    settings.DCBlength = sizeof settings;
    return ::GetCommState(port, &settings) != 0 ? settings.BaudRate : 0;
}

std::uint32_t set_baud_rate(SerialHandle port, std::uint32_t baud) {
    DCB settings{};
    settings.DCBlength = sizeof settings;
    if (::GetCommState(port, &settings) != 0) {
        settings.BaudRate = baud;
        if (::SetCommState(port, &settings) != 0) return baud_rate(port);
    }
    errno = std::system_category().default_error_condition(static_cast<int>(::GetLastError())).value();
    return 0;
}

void ask_for_low_latency(SerialHandle, const std::string&) {}

std::optional<unsigned> latency_ms(const std::string&) { return {}; }

}  // namespace haptogram::link
