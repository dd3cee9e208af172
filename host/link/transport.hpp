// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

namespace haptogram::link {

/// A byte stream to a board: a serial port, or the simulated line of a Verilated board.
class Transport {
public:
    Transport() = default;
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;
    virtual ~Transport() = default;

    virtual void write(std::span<const std::uint8_t> bytes) = 0;
    /// What has arrived; waits at most `patience` (of the board's time) for the first byte. Empty when nothing came.
    [[nodiscard]] virtual std::vector<std::uint8_t> read(std::chrono::microseconds patience) = 0;
};

}  // namespace haptogram::link
