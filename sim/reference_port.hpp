// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "board.hpp"
#include "haptogram/link/port.hpp"

namespace haptogram::sim {

/// What opens a port, again after a loss. "reference:NAME" is a reference board of that configuration in this process:
/// it keeps real time, but stands still while nobody reads from its line, and then catches up.
/// @throws Error{bad_argument} when there is no such configuration
[[nodiscard]] std::function<std::unique_ptr<link::Transport>()> opener_of(const link::PortSettings& settings);

/// A reference board whose time passes only while its line is waited for, and then as fast as it is computed.
/// @param name  of its configuration; behind a "=", the image that was uploaded to it
/// @throws Error{bad_argument} when there is no such configuration; Error{bad_input} for the image
[[nodiscard]] std::unique_ptr<link::Transport> reference_line(const std::string& name);

/// The board of opener_of() behind its line, with what looks at its edges.
[[nodiscard]] std::unique_ptr<link::Transport> reference_port(const std::string& configuration,
                                                              std::function<void(const Edge&)> on_edge = {});

}  // namespace haptogram::sim
