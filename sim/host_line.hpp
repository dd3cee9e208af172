// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace haptogram::sim {

/// What a virtual board is reached by from other programs.
class HostLine {
public:
    HostLine() = default;
    HostLine(const HostLine&) = delete;
    HostLine& operator=(const HostLine&) = delete;
    virtual ~HostLine() = default;

    /// What others call it.
    [[nodiscard]] virtual std::string name() const = 0;
    /// What has come for the board; waits at most this long for it.
    [[nodiscard]] virtual std::vector<std::uint8_t> read(std::chrono::milliseconds patience) = 0;
    /// What the board has said.
    virtual void write(std::span<const std::uint8_t> bytes) = 0;
};

}  // namespace haptogram::sim
