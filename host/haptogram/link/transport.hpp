// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptogram/base/error.hpp"

namespace haptogram::link {

/// The way to the board is lost, as by an unplug or a reset: what was asked may or may not have been done.
class LinkLost : public Error {
public:
    LinkLost(const std::string& where, const std::string& message) : Error(ErrorCode::device, where, message) {}
};

/// A byte stream to a board: a serial port, or the simulated line of a Verilated board.
class Transport {
public:
    Transport() = default;
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;
    virtual ~Transport() = default;

    /// @throws LinkLost when the port is gone
    virtual void write(std::span<const std::uint8_t> bytes) = 0;
    /// What has arrived; waits at most `patience` (of the board's time) for the first byte. Empty when nothing came.
    [[nodiscard]] virtual std::vector<std::uint8_t> read(std::chrono::microseconds patience) = 0;
};

}  // namespace haptogram::link
