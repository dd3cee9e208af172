// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>

#include "haptogram/link/port.hpp"

namespace haptogram::cli {

/// Adds the options that say where the board is.
void add_port_options(CLI::App& sub, link::PortSettings& settings);
/// Adds the option for the watchdog, for commands that play: how long the board waits for a sign of life from the host.
void add_watchdog_option(CLI::App& sub, std::uint16_t& milliseconds);

}  // namespace haptogram::cli
