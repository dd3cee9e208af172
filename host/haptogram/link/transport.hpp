// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/format/interface.hpp"
#include "haptogram/link/clock.hpp"

namespace haptogram::link {

/// The connection to the board is lost, for example because the cable was pulled or the board was reset. Whether the
/// board carried out what was asked last is unknown.
class LinkLost : public Error {
public:
    LinkLost(const std::string& where, const std::string& message) : Error(ErrorCode::device, where, message) {}
};

/// A port cannot be set to a rate.
class RateRefused : public Error {
public:
    RateRefused(const std::string& where, const std::string& message) : Error(ErrorCode::device, where, message) {}
};

/// The user has asked to end while a board was waited for. The caller that turned outputs on turns them off.
class Interrupted : public Error {
public:
    Interrupted() : Error(ErrorCode::cancelled, "board", "ended before it had answered, because a signal asked to") {}
};

/// How often the user has asked to end: the second time means at once.
using Interrupt = std::function<unsigned()>;

/// A stream of bytes to a board and back: a serial port, datagrams, or the simulated line of a Verilated board.
class Transport {
public:
    Transport() = default;
    Transport(const Transport&) = delete;
    Transport& operator=(const Transport&) = delete;
    virtual ~Transport() = default;

    /// @throws LinkLost when the port is gone, or takes no bytes
    virtual void write(std::span<const std::uint8_t> bytes) = 0;
    /// What was written may wait for more until something is read; this sends it now.
    virtual void flush() {}
    /// What has arrived. Waits at most `patience`, in the board's time, for the first byte; empty when nothing came.
    [[nodiscard]] virtual std::vector<std::uint8_t> read(std::chrono::microseconds patience) = 0;
    /// Takes back as many as possible of the written bytes that have not gone out yet, so that the next bytes go out
    /// soon. A frame may be cut in its middle.
    virtual void discard_output() {}
    /// Holds the line low for longer than any frame does: a board then turns its outputs off and drops a frame that it
    /// has half received. A transport without breaks does nothing.
    virtual void send_break() {}
    /// Whether the board has said that the break has turned its outputs off, which a line cannot.
    [[nodiscard]] virtual bool break_has_acted() { return false; }
    /// While this says so, a port that takes no bytes is not waited for.
    virtual void set_interrupt(const Interrupt&) {}
    /// The line's own time, which is not the machine's when the board is simulated. It outlives all that wait in it.
    [[nodiscard]] virtual Clock& clock() { return machine_clock(); }
    /// How long an answer may take on this line before the request is sent again.
    [[nodiscard]] virtual std::chrono::microseconds patience() const {
        return std::chrono::milliseconds(interface::link_policy::patience_ms);
    }
    /// How many times as often as the policy says something is sent again before the link is lost.
    [[nodiscard]] virtual unsigned rounds() const { return 1; }
    /// How many frames may be under way, in the place of the policy's.
    [[nodiscard]] virtual unsigned window() const { return interface::link_policy::window; }
    /// How many bytes of unanswered frames may be under way: what the board has room for before it takes them apart.
    [[nodiscard]] virtual std::size_t window_bytes() const { return std::numeric_limits<std::size_t>::max(); }
    /// What to look at when nothing answers.
    [[nodiscard]] virtual std::string why_silent() {
        return "check the cable, the baud rate and that the board runs Haptogram; a tile of a chain is named by a # "
               "and its number behind the port";
    }
};

/// How long a break is held: longer than any frame, and than what a chain of tiles needs to pass it on, and so long
/// that no USB bridge swallows it.
[[nodiscard]] constexpr std::chrono::microseconds break_time(std::uint32_t baud) {
    constexpr std::uint64_t bits = 25 + interface::chain::most_tiles / 2 + 2;
    return std::chrono::microseconds(bits * 1'000'000 / baud + 1) + std::chrono::milliseconds(2);
}

}  // namespace haptogram::link
