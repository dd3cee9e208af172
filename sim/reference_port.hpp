// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

#include "haptogram/link/transport.hpp"

namespace haptogram::sim {

/// A reference board of a configuration in this process, which keeps real time, and its line.
/// @throws Error{bad_argument} when there is no such configuration
[[nodiscard]] std::unique_ptr<link::Transport> open_reference(const std::string& configuration);

}  // namespace haptogram::sim
