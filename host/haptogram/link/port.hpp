// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/format/interface.hpp"
#include "haptogram/link/known_rates.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// Where a device is.
struct PortSettings {
    std::string port;  ///< a serial port such as /dev/ttyUSB0, ftdi:[VID:PID[:SERIAL]], udp:ADDRESS[:PORT], or
                       ///< reference:NAME; with `#2` behind it, the second tile of the chain there
    std::optional<std::uint32_t> baud{};    ///< the rate, which the build of the FPGA fixes; none: it is found
    Interrupt interrupt{};                  ///< as Client::set_interrupt() has it
    std::optional<std::uint32_t> likely{};  ///< the rate that the image is for, to be tried before the known ones
    std::function<void(const std::string& port, std::uint32_t baud)> found{};  ///< told a rate that was looked for
};

/// Opens "reference:NAME", a simulated board in this process. Who has simulated boards sets it, before any port is
/// opened; without it there are none.
using OpenReference = std::function<std::unique_ptr<Transport>(const std::string& name)>;
void set_reference_boards(OpenReference open);
inline constexpr std::string_view reference_prefix = "reference:";

/// Opens the port of that name: a simulated board when the name begins with "reference:", an FTDI chip when the name
/// begins with "ftdi:", a board on a network when with "udp:", else a serial port. With "#2" at its end, the second
/// tile of a chain behind it; those of one process share the port.
/// @throws Error{bad_argument} when there is no such number of a tile
/// @throws Error{device} as FtdiPort and SerialPort do, and when this build leaves FTDI out
[[nodiscard]] std::unique_ptr<Transport> open_port(const std::string& name, std::uint32_t baud);

/// The same at the rate at which a board answers, if none is given: the one that is remembered for the port is tried
/// first, then the likely one and the known ones, from the fastest on. A board turns its outputs off when it hears
/// bytes that are slower than its own.
/// @param question  that is asked: IDENTIFY, or what turns the outputs off
/// @param rounds    tries at each rate, after which there is no board
/// @throws LinkLost when no board answers at any rate; Error{device} as above; Interrupted
[[nodiscard]] std::unique_ptr<Transport> open_port(const PortSettings& settings,
                                                   interface::Command question = interface::Command::identify,
                                                   unsigned rounds = probe_rounds);

/// The port of a board whose outputs are to be turned off: where its rate is not known, the question turns them off
/// already. To one that answers at none, a break is left, which is one at any rate.
[[nodiscard]] std::unique_ptr<Transport> open_port_to_turn_off(const PortSettings& settings);

/// A port that a device may be behind.
struct PortInfo {
    std::string port;  ///< what PortSettings take
    std::string name;  ///< what the chip behind it says it is; may be empty
    friend auto operator<=>(const PortInfo&, const PortInfo&) = default;
};

/// The serial ports that lead to USB, and the FTDI chips, sorted.
[[nodiscard]] std::vector<PortInfo> available_ports();

}  // namespace haptogram::link
