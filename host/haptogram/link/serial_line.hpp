// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

/// What each operating system does with a serial port in its own way, beside what Boost.Asio does:
/// serial_line_posix.cpp and serial_line_windows.cpp have the same functions. Where one fails, errno says why.
namespace haptogram::link {

#ifdef _WIN32
using SerialHandle = void*;
#else
using SerialHandle = int;
#endif

/// No other program of ours gets the port until it is closed or this process ends, in whatever way, and no program that
/// this one starts. @return false when another has it
[[nodiscard]] bool keep_to_us(SerialHandle port);
/// Forgets what waits to be written, and if asked, what waits to be read.
void forget(SerialHandle port, bool also_received);
/// @return false when this line knows no break
bool hold_break(SerialHandle port, bool on);
/// Waits until it may take bytes, at most so long. @return whether it may, or has an error to tell
[[nodiscard]] bool wait_to_write(SerialHandle port, std::chrono::milliseconds patience);

/// Has a USB adapter send on what it received at once, instead of collecting it: FTDI's collect for 16 ms.
void ask_for_low_latency(SerialHandle port, const std::string& path);
/// For how many ms the adapter of a port collects what it received; nothing where that is not known.
[[nodiscard]] std::optional<unsigned> latency_ms(const std::string& path);

/// The rate of a port, or of the terminal whose master this is; 0 when it has none.
[[nodiscard]] std::uint32_t baud_rate(SerialHandle port);
/// Sets the rate, in both directions, to any number of baud.
/// @return the rate that the driver made of it; 0 when the system refuses
[[nodiscard]] std::uint32_t set_baud_rate(SerialHandle port, std::uint32_t baud);

}  // namespace haptogram::link
