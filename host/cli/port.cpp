// SPDX-License-Identifier: Apache-2.0
#include "port.hpp"

#include "command.hpp"

namespace haptogram::cli {

void add_port_options(CLI::App& sub, link::PortSettings& settings) {
    sub.add_option("--port", settings.port,
                   "Serial port of the board, or of 'haptogram board run', or ftdi:[VID:PID[:SERIAL]]; #N behind it is "
                   "tile N of a chain")
        ->required();
    sub.add_option("--baud", settings.baud, "Its rate, which the board's build fixes")
        ->check(whole(300, 12'000'000))
        ->capture_default_str();
}

void add_watchdog_option(CLI::App& sub, std::uint16_t& milliseconds) {
    sub.add_option("--watchdog", milliseconds,
                   "Outputs go off when this program is silent for so many ms; 0: never, they may stay on when it dies")
        ->check(whole(0, 65535))
        ->capture_default_str();
}

}  // namespace haptogram::cli
