// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// Where a device is.
struct PortSettings {
    std::string port;  ///< a serial port such as /dev/ttyUSB0, or ftdi:[VID:PID[:SERIAL]]; #N behind it: tile N of the
                       ///< chain there
    std::uint32_t baud = 1'000'000;  ///< the rate, which the build of the FPGA fixes
    Interrupt interrupt{};           ///< as Client::set_interrupt() has it
};

/// Opens the port of that name: an FTDI chip when the name begins with "ftdi:", else a serial port. With "#2" at its
/// end, the second tile of a chain behind it; those of one process share the port.
/// @throws Error{bad_argument} when there is no such number of a tile
/// @throws Error{device} as FtdiPort and SerialPort do, and when this build leaves FTDI out
[[nodiscard]] std::unique_ptr<Transport> open_port(const std::string& name, std::uint32_t baud);

/// A port that a device may be behind.
struct PortInfo {
    std::string port;  ///< what PortSettings take
    std::string name;  ///< what the chip behind it says it is; may be empty
    friend auto operator<=>(const PortInfo&, const PortInfo&) = default;
};

/// The serial ports that lead to USB, and the FTDI chips, sorted.
[[nodiscard]] std::vector<PortInfo> available_ports();

}  // namespace haptogram::link
