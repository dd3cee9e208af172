// SPDX-License-Identifier: Apache-2.0
#include "port.hpp"

#include <algorithm>

#include "command.hpp"
#include "haptogram/link/port.hpp"

namespace haptogram::cli {
namespace {

// A frame takes its time on the line, and a simulated board more: with a trace it may be a hundred times slower.
constexpr std::chrono::milliseconds patience{300};
constexpr std::chrono::seconds most_patience{10};

}  // namespace

void add_port_options(CLI::App& sub, PortOptions& options) {
    sub.add_option("--port", options.port,
                   "Serial port of the board, or of 'haptogram board run', or ftdi:[VID:PID[:SERIAL]]")
        ->required();
    sub.add_option("--baud", options.baud, "Its rate, which the board's build fixes")
        ->check(whole(300, 12'000'000))
        ->capture_default_str();
}

void add_watchdog_option(CLI::App& sub, std::uint16_t& milliseconds) {
    sub.add_option("--watchdog", milliseconds,
                   "Outputs go off when this program is silent for so many ms; 0: never, they may stay on when it dies")
        ->check(whole(0, 65535))
        ->capture_default_str();
}

std::chrono::milliseconds keep_alive_pause(std::uint16_t watchdog_ms) {
    constexpr int longest = 100;
    return std::chrono::milliseconds(watchdog_ms == 0 ? longest : std::min(longest, watchdog_ms / 5 + 1));
}

Device::Device(const PortOptions& options) : port_(link::open_port(options.port, options.baud)), client_(*port_) {
    client_.set_patience(patience, most_patience);
    identity_ = client_.identify();
}

}  // namespace haptogram::cli
