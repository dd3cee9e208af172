// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/boards/interface.hpp"

namespace haptogram::link {

/// The connection to the board is lost, for example because the cable was pulled or the board was reset. Whether the
/// board carried out what was asked last is unknown.
class LinkLost : public Error {
public:
    LinkLost(const std::string& where, const std::string& message) : Error(ErrorCode::device, where, message) {}
};

/// A stream of bytes to a board and back: a serial port, or the simulated line of a Verilated board.
class Transport {
public:
    Transport() = default;
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;
    virtual ~Transport() = default;

    /// @throws LinkLost when the port is gone, or takes no bytes
    virtual void write(std::span<const std::uint8_t> bytes) = 0;
    /// What has arrived. Waits at most `patience`, in the board's time, for the first byte; empty when nothing came.
    [[nodiscard]] virtual std::vector<std::uint8_t> read(std::chrono::microseconds patience) = 0;
    /// Takes back as much as possible of what was written and has not gone out yet, so that what is written next goes
    /// out soon. A frame may be cut in its middle.
    virtual void discard_output() {}
    /// How long an answer may take on this line before the request is sent again.
    [[nodiscard]] virtual std::chrono::microseconds patience() const {
        return std::chrono::milliseconds(interface::link_policy::patience_ms);
    }
};

}  // namespace haptogram::link
