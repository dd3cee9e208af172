// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "verbs.hpp"

namespace haptogram::serve {

struct ServerOptions {
    std::uint16_t port = 0;            ///< of the WebSocket; 0: one that is free
    std::uint16_t osc_port = 0;        ///< of OSC over UDP; 0: none
    std::string token;                 ///< that every WebSocket must bring; empty: none
    std::vector<std::string> origins;  ///< of pages that are let in, such as "https://example.org"
};

/// Serves clients on the loopback interface, each in a thread of its own, until it is told to end.
/// @param listening  told the WebSocket's port once it is open
/// @param go_on      asked ten times a second; false ends it
/// @throws Error{bad_argument} when a port is taken
void run(Verbs& verbs, const ServerOptions& options, const std::function<void(std::uint16_t port)>& listening,
         const std::function<bool()>& go_on);

}  // namespace haptogram::serve
