// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "haptogram/link/client.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::cli {

/// The options that say where the board is.
struct PortOptions {
    std::string port;
    std::uint32_t baud = 1'000'000;
};

void add_port_options(CLI::App& sub, PortOptions& options);
/// Of a command that plays: for how long the board waits for a sign of life from it.
void add_watchdog_option(CLI::App& sub, std::uint16_t& milliseconds);
/// How often such a command gives one.
[[nodiscard]] std::chrono::milliseconds keep_alive_pause(std::uint16_t watchdog_ms);

/// A board behind a port, with a session begun.
class Device {
public:
    /// @throws Error{device} when the port cannot be opened or no Haptogram answers
    explicit Device(const PortOptions& options);

    link::Client& client() { return client_; }
    [[nodiscard]] const link::Identity& identity() const { return identity_; }

private:
    std::unique_ptr<link::Transport> port_;
    link::Client client_;
    link::Identity identity_;
};

}  // namespace haptogram::cli
