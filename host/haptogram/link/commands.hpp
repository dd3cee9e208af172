// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/link/clock.hpp"
#include "haptogram/link/frame.hpp"

namespace haptogram::link {

// Names in this folder: a *device* is a Haptogram instrument that is reached through a port; its Identity says what it
// is and its Status what it is doing. A Board (haptogram/format) is the description of a circuit board in a file;
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
    std::uint32_t width_bits = 0;        ///< of a channel's own pulse width; 0: the pulses of a record have one length
    std::uint32_t foci = 0;              ///< most foci of a focus record; 0: it computes none
    std::uint32_t modulation_words = 0;  ///< of two samples; 0: it has no modulation
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
        core.width_bits = width_bits;
        core.modulation_depth = 2 * modulation_words;
        core.slew = interface::has(features, interface::Feature::slew) ? 1 : 0;
        core.foci = foci;
        core.schedule = interface::has(features, interface::Feature::schedule) ? 1 : 0;
        core.sync = interface::has(features, interface::Feature::sync) ? 1 : 0;
        core.chain = interface::has(features, interface::Feature::chain) ? 1 : 0;
        core.trigger = interface::has(features, interface::Feature::trigger) ? 1 : 0;
        core.max_high_clocks = max_high_clocks(max_pulse_clocks);
        return core;
    }
};

using interface::Flash;
using interface::Mode;
using interface::Role;

/// What became of a stream's patterns that did not play in their own carrier period.
struct StreamCounts {
    bool playing = false;  ///< a stream plays
    std::uint16_t late = 0, lost = 0, early = 0, repeated = 0;
    friend bool operator==(const StreamCounts&, const StreamCounts&) = default;
};

/// What a device says it is doing. Counters begin at 0 again after 65,535.
struct Status {
    bool enabled = false;             ///< pulses are let out
    bool stopped = false;             ///< the stop input is active: outputs stay off
    bool modulated = false;           ///< the modulation runs
    bool waiting = false;             ///< a start, a modulation or pushed indices wait for their time
    Mode mode = Mode::idle;           ///< idle: nothing is to come; the last record may still be playing
    std::uint16_t present_index = 0;  ///< of the record that plays; 0 is silence
    std::uint16_t underruns = 0, refused_records = 0, frames_good = 0, frames_damaged = 0, frames_repeated = 0,
                  frames_refused = 0, watchdog_trips = 0, guard_trips = 0, bent_periods = 0, far_foci = 0;
    Role role = Role::alone;
    bool in_step = false;   ///< of a slave: its carrier cycles begin with the master's
    bool numbered = false;  ///< they have the master's numbers, too
    std::uint16_t sync_misses = 0, sync_losses = 0;
    std::uint16_t live_level = 0;   ///< entries in the live FIFO
    std::uint16_t watchdog_ms = 0;  ///< outputs go off after so long without a new command; 0: never
    /// Changes that came too late for their carrier period, and its number at the pins, which begins at 0 with a reset;
    /// a device without schedule counts neither.
    std::uint16_t late_changes = 0;
    std::optional<std::uint64_t> period{};
    std::optional<StreamCounts> stream{};  ///< of a device that takes streams of patterns
    Flash flash = Flash::none;             ///< what became of the image in its flash, of a device with an SDRAM
    friend bool operator==(const Status&, const Status&) = default;
};

/// From the blocks that identify and status answer with. @throws Error{device} naming the field when they are of
/// another instrument, or say what no instrument can (rtl/INTERFACE.md)
[[nodiscard]] Identity to_identity(const Bytes& block);
[[nodiscard]] Status to_status(const Bytes& block);

/// When a change takes effect. Until then what plays goes on.
struct When {
    std::uint64_t gate = 0;  ///< as the command `gate` has it

    [[nodiscard]] static constexpr When at_once() { return {}; }
    /// When what plays now has ended: all its loops, or its present pass when it is played for ever.
    [[nodiscard]] static constexpr When at_end() { return {(std::uint64_t{1} << 48) - 1}; }
    /// When the trigger input says so, of a device that has one; not for what is pushed.
    [[nodiscard]] static constexpr When at_trigger() { return {at_end().gate - 1}; }
    /// With this carrier period, or with the first one after it that the change can be ready for; never before it.
    /// @throws Error{bad_argument} when it has no number that a device counts to
    [[nodiscard]] static When at_period(std::uint64_t period);
    friend bool operator==(const When&, const When&) = default;
};

/// One request: a command and its payload.
struct Request {
    interface::Command command;
    Bytes payload;
};

/// Writes words of 16 bits.
[[nodiscard]] Request write_request(std::uint32_t address, std::span<const std::uint16_t> words);
[[nodiscard]] Request write_request(std::uint32_t address, const Bytes& bytes);
/// A READ or DIGEST of this many bytes.
[[nodiscard]] Request asking_request(interface::Command command, std::uint32_t address, std::size_t bytes);
/// What Commands::push() and push_foci() send.
[[nodiscard]] Request push_request(std::span<const std::uint16_t> indices, std::uint16_t dwell);
[[nodiscard]] Request push_foci_request(std::span<const std::uint16_t> words, std::uint16_t dwell);
/// The requests that Commands::select(), start(), modulate() and set_watchdog() send, for changes without a gate.
[[nodiscard]] Request select_request(std::uint16_t index, std::uint16_t dwell);
[[nodiscard]] Request start_request(std::uint16_t first, std::uint16_t length, std::uint16_t loops);
/// What comes next waits.
[[nodiscard]] Request gate_request(When when);
[[nodiscard]] Request modulate_request(std::uint16_t divider, std::uint16_t length, bool loop, std::uint32_t first = 0);
[[nodiscard]] Request watchdog_request(std::uint16_t milliseconds);
/// Patterns for this carrier period and those after it, for tell().
[[nodiscard]] Request stream_request(std::uint64_t period, std::span<const std::uint16_t> patterns);

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
    /// As one of many requests, in their order; turn_off() is for all that must end.
    void disable() { request({interface::Command::disable, {}}); }
    void stop() { request({interface::Command::stop, {}}); }
    /// Plays a record from the next cycle on, for `dwell` cycles or, with 0, until something else comes.
    void select(std::uint16_t index, std::uint16_t dwell = 0);
    /// Appends indices to the live FIFO. @return how many entries it holds now
    /// @param when  neither at_end() nor at_trigger()
    std::uint16_t push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell, When when = {});
    /// Writes focus records, of four words a focus, into the ring and appends their indices to the live FIFO.
    /// @return how many entries it holds now
    std::uint16_t push_foci(std::span<const std::uint16_t> words, std::uint16_t dwell);
    /// Plays entries of the sequence: a bank of it. @param length  0: length and loops are those of the sequence's
    /// header
    void start(std::uint16_t first, std::uint16_t length, std::uint16_t loops, When when = {});
    /// Multiplies all amplitudes by `length` samples of the modulation memory, each for `divider` carrier
    /// periods, over and over or once. @param divider  0: ends that  @param length  0: all samples from the first on
    /// @param first  number of the first sample, even
    void modulate(std::uint16_t divider, std::uint16_t length, bool loop, std::uint32_t first = 0, When when = {});
    /// After how long without a new command the outputs go off; 0: never.
    void set_watchdog(std::uint16_t milliseconds);
    /// Resets the device, and then keeps its carrier cycles in step with other boards.
    void set_role(Role role);
    /// Starts the watchdog's time anew and does nothing else.
    void keep_alive() { request({interface::Command::keep_alive, {}}); }
    /// As after power-up, but memories and session stay.
    void reset() { request({interface::Command::reset, {}}); }
    void write(std::uint32_t address, const Bytes& bytes);
    Bytes read(std::uint32_t address, std::uint16_t bytes);

    /// One request and its reply.
    Reply request(Request request);
    /// The same, which takes effect then. When the device refuses it, nothing waits any more.
    Reply request(Request wanted, When when);
    /// Many requests, several under way at once; replies in order.
    /// @param progress  told the fraction done after each reply
    std::vector<Reply> pipeline(std::vector<Request> requests, const Progress& progress = {});

    /// Queues a request. Its reply is handed to `done` from within wait(); a command whose reply carries no data may
    /// get one that was made up here, after a later reply has shown that it was applied.
    virtual void submit(Request request, std::function<void(const Reply&)> done = {}) = 0;
    /// Sends a request that gets no answer and is never sent again, ahead of the queue; sends nothing while the outputs
    /// are being shut off. flush() sends the bytes that a port gathers.
    virtual void tell(Request request) = 0;
    /// Sends as much of the queue as can be sent without waiting for an answer.
    virtual void flush() = 0;
    /// Waits until at most this many requests are unanswered.
    virtual void wait(std::size_t most_unanswered = 0) = 0;
    [[nodiscard]] virtual std::size_t unanswered() const = 0;
    /// Drops what is queued. Requests that are under way may still be carried out, but their answers are dropped.
    virtual void drop() = 0;
    /// Frames that were sent again because the line had lost them or their answers.
    [[nodiscard]] virtual std::uint64_t retransmissions() const = 0;
    /// The time of its line, in which callers wait.
    [[nodiscard]] virtual Clock& clock() = 0;
    /// Turns the outputs off ahead of everything that is queued, whatever came before and whatever the line has lost.
    /// @return whether the device has confirmed it
    virtual bool turn_off() = 0;
    /// From now on something new is said at least so often while answers are waited for, and so twice while one is
    /// late; 0: no more.
    virtual void keep_alive_every(std::chrono::milliseconds /*pause*/) {}

protected:
    /// Called before requests of their own by request() and pipeline().
    virtual void make_ready() {}
};

/// The bytes of data that the reply to a request has.
[[nodiscard]] std::size_t expected_bytes(const Request& request, const Identity& identity);

/// That a reply to a request is one: its data as long as was asked for, its values within what the device has.
/// @param identity  of the device; of no meaning for identify
/// @throws Error{device} naming the field, what was found and what was expected
void require_sound(const Reply& reply, const Request& request, const Identity& identity);

/// How often a host must say something while outputs are on, for a device with such a watchdog.
[[nodiscard]] std::chrono::milliseconds keep_alive_pause(std::uint16_t watchdog_ms);

}  // namespace haptogram::link
