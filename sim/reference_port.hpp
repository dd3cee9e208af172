// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "haptogram/link/port.hpp"

namespace haptogram::sim {

/// A reference board of a configuration in this process, which keeps real time, and its line.
/// @throws Error{bad_argument} when there is no such configuration
[[nodiscard]] std::unique_ptr<link::Transport> open_reference(const std::string& configuration);

/// What opens a port, or "reference:NAME", again after a loss.
/// @throws Error{bad_argument} when there is no such configuration
[[nodiscard]] std::function<std::unique_ptr<link::Transport>()> opener_of(const link::PortSettings& settings);

}  // namespace haptogram::sim
