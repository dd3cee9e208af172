// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/boards/core.hpp"
#include "haptogram/link/frame.hpp"

namespace haptogram::link {

// Names in this folder: a *device* is a Haptogram instrument that is reached through a port; its Identity says what it
// is and its Status what it is doing. A Board (haptogram/boards) is the description of a circuit board in a file;
// sim::SimulatedBoard is a Verilated core. Messages to users call the device "board": that is what stands on the table.

/// What a device says it is; fixed when its FPGA was synthesised.
struct Identity {
    std::string name;
    unsigned version_major = 0, version_minor = 0;
    std::uint32_t channels = 0, records = 0, sequence_depth = 0, live_depth = 0;
    std::uint32_t timing_bits = 0, pulse_bits = 0, clock_hz = 0, features = 0;
    std::uint32_t frame_bytes = 0;  ///< the longest frame that it always takes, decoded and without its CRC
    std::uint32_t min_pulse_clocks = 0, max_pulse_clocks = 0, max_cycle_clocks = 0;  ///< of a record that it plays
    std::uint32_t max_duty_256 = 0;                                                  ///< of its cycle, in 1/256
    friend bool operator==(const Identity&, const Identity&) = default;

    /// The parameters of the core that it tells; those that it does not tell have their default.
    [[nodiscard]] interface::CoreParameters core() const {
        interface::CoreParameters core;
        core.channels = channels;
        core.records = records;
        core.sequence_depth = sequence_depth;
        core.live_depth = live_depth;
        core.timing_bits = timing_bits;
        core.pulse_bits = pulse_bits;
        core.clock_hz = clock_hz;
        core.min_pulse_clocks = min_pulse_clocks;
        core.max_duty_256 = max_duty_256;
        core.max_high_clocks = max_high_clocks(max_pulse_clocks);
        return core;
    }
};

using interface::Mode;

/// What a device says it is doing. Counters begin at 0 again after 65,535.
struct Status {
    bool enabled = false;             ///< pulses are let out
    bool stopped = false;             ///< the stop input is active: outputs stay off
    Mode mode = Mode::idle;           ///< idle: the last record may still be playing
    std::uint16_t present_index = 0;  ///< of the record that plays; 0 is silence
    std::uint16_t underruns = 0, refused_records = 0, frames_good = 0, frames_damaged = 0, frames_repeated = 0,
                  frames_refused = 0, watchdog_trips = 0, guard_trips = 0;
    std::uint16_t live_level = 0;   ///< entries in the live FIFO
    std::uint16_t watchdog_ms = 0;  ///< outputs go off after so long without a new command; 0: never
    friend bool operator==(const Status&, const Status&) = default;
};

/// From the blocks that identify and status answer with. @throws Error{device} when they are of another instrument or
/// too short
[[nodiscard]] Identity to_identity(const Bytes& block);
[[nodiscard]] Status to_status(const Bytes& block);

/// One request: a command and its payload.
struct Request {
    interface::Command command;
    Bytes payload;
};

/// The commands of a device as functions. Client sends them in the caller's own thread; a channel of DeviceThread hands
/// them to the thread that owns the port. What works with either (upload, play, stream, LiveFeed) takes a Commands.
///
/// Every function may throw LinkLost, when the port is gone, nothing answers, or the device has forgotten the session
/// because of a reset, and Error{device} when the device refuses a command; the message says which and why. What was
/// queued behind a refused command is dropped.
class Commands {
public:
    Commands() = default;
    Commands(const Commands&) = delete;
    Commands& operator=(const Commands&) = delete;
    virtual ~Commands() = default;

    /// As the device said when the session began.
    [[nodiscard]] virtual const Identity& identity() const = 0;

    Status status();
    void enable() { request({interface::Command::enable, {}}); }
    void disable() { request({interface::Command::disable, {}}); }
    void stop() { request({interface::Command::stop, {}}); }
    /// Plays a record from the next cycle on, for `dwell` cycles or, with 0, until something else comes.
    void select(std::uint16_t index, std::uint16_t dwell = 0);
    /// Appends indices to the live FIFO. @return how many entries it holds now
    std::uint16_t push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell);
    /// Plays entries of the sequence. @param length  0: length and loops are those of the sequence's header
    void start(std::uint16_t first, std::uint16_t length, std::uint16_t loops);
    /// After how long without a new command the outputs go off; 0: never.
    void set_watchdog(std::uint16_t milliseconds);
    /// Starts the watchdog's time anew and does nothing else.
    void keep_alive() { request({interface::Command::keep_alive, {}}); }
    /// As after power-up, but memories and session stay.
    void reset() { request({interface::Command::reset, {}}); }
    void write(std::uint32_t address, const Bytes& bytes);
    Bytes read(std::uint32_t address, std::uint16_t bytes);

    /// One request and its reply.
    Reply request(Request request);
    /// Many requests, several under way at once; replies in order.
    /// @param progress  told the fraction done after each reply
    std::vector<Reply> pipeline(std::vector<Request> requests, const Progress& progress = {});

    /// Queues a request. Its reply is handed to `done` from within wait(); a command whose reply carries no data may
    /// get one that was made up here, after a later reply has shown that it was applied.
    virtual void submit(Request request, std::function<void(const Reply&)> done = {}) = 0;
    /// Sends what can be sent of what is queued, without waiting for an answer.
    virtual void flush() = 0;
    /// Waits until at most so many requests are unanswered.
    virtual void wait(std::size_t most_unanswered = 0) = 0;
    [[nodiscard]] virtual std::size_t unanswered() const = 0;
    /// Drops what is queued. What is under way already may still be carried out, but nobody is told of it.
    virtual void drop() = 0;
    /// Frames that were sent again because the line had lost them or their answers.
    [[nodiscard]] virtual std::uint64_t retransmissions() const = 0;

protected:
    /// Called before requests of their own by request() and pipeline().
    virtual void make_ready() {}
};

/// How often a host must say something while outputs are on, for a device with such a watchdog.
[[nodiscard]] std::chrono::milliseconds keep_alive_pause(std::uint16_t watchdog_ms);

}  // namespace haptogram::link
