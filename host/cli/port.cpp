// SPDX-License-Identifier: Apache-2.0
#include "port.hpp"

#include <fmt/format.h>

#include "command.hpp"
#include "haptogram/link/serial_line.hpp"

namespace haptogram::cli {

void add_port_options(CLI::App& sub, link::PortSettings& settings) {
    sub.add_option("--port", settings.port,
                   "Serial port of the board, or of 'haptogram board run', ftdi:[VID:PID[:SERIAL]], "
                   "udp:ADDRESS[:PORT], or reference:NAME[=IMAGE] for a simulated one; #N behind it is tile N of a "
                   "chain")
        ->required();
    add_baud_option(sub, settings.baud);
    settings.found = tell_rate;
}

void add_baud_option(CLI::App& sub, std::optional<std::uint32_t>& baud) {
    sub.add_option(
           "--baud", baud,
           fmt::format("Baud rate, fixed by the board's build (default: tries {}, and remembers the one that works)",
                       fmt::join(link::known_rates, ", ")))
        ->check(whole(300, 12'000'000));
}

void tell_rate(const std::string& port, std::uint32_t baud) {
    complain(fmt::format("{}: it answers at {} baud, which is remembered", port, baud));
}

void warn_of_latency(const std::string& port) {
    const std::optional<unsigned> waits_ms = link::latency_ms(port);
    if (waits_ms.value_or(1) > 1)
        complain(fmt::format(
            "warning: {}: its adapter keeps what the board answers for up to {} ms (its latency timer), and "
            "streams may run dry; write 1 into /sys/class/tty/PORT/device/latency_timer, or install the "
            "package's udev rule",
            port, *waits_ms));
}

void add_watchdog_option(CLI::App& sub, std::uint16_t& milliseconds) {
    sub.add_option("--watchdog", milliseconds,
                   "Outputs go off when this program is silent for so many ms; 0: never, they may stay on when it dies")
        ->check(whole(0, 65535))
        ->capture_default_str();
}

}  // namespace haptogram::cli
