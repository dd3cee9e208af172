// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "haptogram/link/port.hpp"

namespace haptogram::cli {

/// Adds the options that say where the board is.
void add_port_options(CLI::App& sub, link::PortSettings& settings);
/// Adds the option that fixes the port's rate.
void add_baud_option(CLI::App& sub, std::optional<std::uint32_t>& baud);
/// Warns of a port whose adapter keeps what it received for longer than a command that plays can do with.
void warn_of_latency(const std::string& port);
/// Says a rate that was found.
void tell_rate(const std::string& port, std::uint32_t baud);
/// Adds the option for the watchdog, for commands that play: how long the board waits for a sign of life from the host.
void add_watchdog_option(CLI::App& sub, std::uint16_t& milliseconds);

}  // namespace haptogram::cli
