// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>

#include "haptogram/link/port.hpp"

namespace haptogram::cli {

/// The options that say where the board is.
void add_port_options(CLI::App& sub, link::PortSettings& settings);
/// The option of a command that plays: for how long the board waits for a sign of life from it.
void add_watchdog_option(CLI::App& sub, std::uint16_t& milliseconds);

}  // namespace haptogram::cli
