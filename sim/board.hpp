// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/format/interface.hpp"
#include "model.hpp"

namespace haptogram::sim {

/// A pin changed its level. `clock` counts from the first clock of the simulation; `index` is the record that played.
struct Edge {
    std::uint64_t clock;
    std::uint32_t channel;
    std::uint16_t index;
    bool rises;
    friend bool operator==(const Edge&, const Edge&) = default;
};

/// A carrier cycle began at the pins: tick 0 of a cycle of record `index`.
struct CycleStart {
    std::uint64_t clock;
    std::uint16_t index;
    bool enabled;
    friend bool operator==(const CycleStart&, const CycleStart&) = default;
};

/// The board changed the level of the wire SYNC.
struct SyncChange {
    std::uint64_t clock;
    bool level;
    friend bool operator==(const SyncChange&, const SyncChange&) = default;
};

/// The trigger output changed its level.
struct TriggerChange {
    std::uint64_t clock;
    bool level;
    friend bool operator==(const TriggerChange&, const TriggerChange&) = default;
};

/// The host's end of the line has received a byte from the board.
struct Arrival {
    std::uint64_t clock;
    std::uint8_t byte;
    friend bool operator==(const Arrival&, const Arrival&) = default;
};

/// A board without hardware, with its clock and reset, the host's end of its serial line, and observers at its pins:
/// SimulatedBoard runs the Verilog, ReferenceBoard computes what it would do.
class Board {
public:
    Board() = default;
    Board(const Board&) = delete;
    Board& operator=(const Board&) = delete;
    virtual ~Board() = default;

    /// Runs this many clocks.
    virtual void run(std::uint64_t clocks) = 0;
    /// Runs until `done`, asked every 16 clocks, says so. @return false when `limit` clocks passed first
    bool run_until(const std::function<bool()>& done, std::uint64_t limit) {
        for (const std::uint64_t end = now() + limit; !done();) {
            if (now() >= end) return false;
            run(16);
        }
        return true;
    }
    virtual void reset(unsigned clocks = 4) = 0;

    [[nodiscard]] virtual std::uint64_t now() const = 0;
    [[nodiscard]] virtual const interface::CoreConfiguration& configuration() const = 0;
    /// Name of the configuration, as it was asked for.
    [[nodiscard]] std::string_view name() const { return configuration().name; }
    [[nodiscard]] const interface::CoreParameters& parameters() const { return configuration().parameters; }
    /// What is at the ports after the last clock. A reference board computes pulses for somebody who looks at them.
    [[nodiscard]] virtual const Model::Outputs& outputs() = 0;
    /// What of it can be had for nothing.
    struct Present {
        std::uint16_t index;
        bool enabled;
        [[nodiscard]] bool playing() const { return enabled && index != 0; }
    };
    [[nodiscard]] virtual Present present() const = 0;
    [[nodiscard]] bool pin(std::uint32_t channel) {
        return ((outputs().pins[channel / 32] >> (channel % 32)) & 1U) != 0;
    }
    [[nodiscard]] bool any_pin() {
        return std::ranges::any_of(outputs().pins, [](std::uint32_t word) { return word != 0; });
    }

    /// Queues bytes for the board's receiver.
    virtual void send(std::span<const std::uint8_t> bytes) = 0;
    /// The bytes that have arrived from the board since the last call.
    [[nodiscard]] virtual std::vector<std::uint8_t> receive() = 0;
    [[nodiscard]] virtual std::size_t received() const = 0;
    [[nodiscard]] virtual bool line_idle() const = 0;
    /// Holds the receiver's line at a level, as noise or a broken cable would; an empty value lets go.
    virtual void force_line(std::optional<bool> level) = 0;
    virtual void unplug() = 0;
    /// Of a board with a network port, whose bytes send() and receive() carry, one a clock each: somebody turns its
    /// outputs off, or sends a STOP; its link is lost; there is another peer. On other boards nothing comes of it.
    virtual void network_break() = 0;
    virtual void network_stop() = 0;
    virtual void network_lost() = 0;
    virtual void network_end() = 0;
    /// Presses the stop switch, or releases it.
    virtual void press_stop(bool pressed) = 0;
    /// The level at the wire SYNC, of boards that have it.
    virtual void drive_sync(bool level) = 0;

    /// The level at the trigger input, likewise.
    virtual void drive_trigger(bool level) = 0;

    /// Observers. Each kind is told in the order of clocks; edges of one clock come in the order of channels, after the
    /// cycle that begins with them.
    virtual void on_edge(std::function<void(const Edge&)> callback) { on_edge_ = std::move(callback); }
    void on_cycle_start(std::function<void(const CycleStart&)> callback) { on_cycle_start_ = std::move(callback); }
    void on_arrival(std::function<void(const Arrival&)> callback) { on_arrival_ = std::move(callback); }
    void on_sync(std::function<void(const SyncChange&)> callback) { on_sync_ = std::move(callback); }
    void on_trigger(std::function<void(const TriggerChange&)> callback) { on_trigger_ = std::move(callback); }

    /// To be changed while no record is loaded, as after a reset: the boards differ in when they read a word. Empty
    /// where the memories can only be reached over the link.
    [[nodiscard]] virtual std::span<std::uint16_t> primary_memory() = 0;
    [[nodiscard]] virtual std::span<std::uint32_t> sequence_memory() = 0;

protected:
    std::function<void(const Edge&)> on_edge_;
    std::function<void(const CycleStart&)> on_cycle_start_;
    std::function<void(const Arrival&)> on_arrival_;
    std::function<void(const SyncChange&)> on_sync_;
    std::function<void(const TriggerChange&)> on_trigger_;
};

}  // namespace haptogram::sim
