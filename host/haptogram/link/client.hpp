// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/link/frame.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// What a board says it is.
struct Identity {
    std::string name;
    unsigned version_major = 0, version_minor = 0;
    std::uint32_t channels = 0, records = 0, sequence_depth = 0, live_depth = 0;
    std::uint32_t timing_bits = 0, pulse_bits = 0, clock_hz = 0, features = 0, frame_bytes = 0;
    friend bool operator==(const Identity&, const Identity&) = default;
};

/// What a board says it is doing; counters run modulo 65,536.
struct BoardStatus {
    bool enabled = false;
    unsigned mode = 0;
    std::uint16_t present_index = 0, underruns = 0, refused_records = 0, frames_good = 0, frames_damaged = 0,
                  frames_repeated = 0, frames_refused = 0, watchdog_trips = 0, guard_trips = 0, live_level = 0,
                  watchdog_ms = 0;
};

/// One request: a command and its payload.
struct Request {
    interface::Command command;
    Bytes payload;
};

/// Speaks to a board, in the caller's thread, and sleeps while it waits. Requests go out in a window, each is
/// acknowledged, and what is lost is sent again from the first missing one on; the board applies each exactly once and
/// in order. host/haptogram/link/example.cpp is a program of twenty lines on it.
///
/// Every function may throw LinkLost, when the port is gone, nothing answers, or the board has lost the session by a
/// reset (identify again), and Error{device} when the board refused a command, which says which and why. What was
/// queued behind that is dropped.
class Client {
public:
    explicit Client(Transport& transport) : transport_(transport) {}

    /// Starts a session; nothing else is answered before it. @throws Error{device} also when what answers is no
    /// Haptogram
    Identity identify();
    BoardStatus status();
    void enable() { request({interface::Command::enable, {}}); }
    void disable() { request({interface::Command::disable, {}}); }
    void stop() { request({interface::Command::stop, {}}); }
    /// Plays a record from the next cycle on, for `dwell` cycles or, with 0, until something else comes.
    void select(std::uint16_t index, std::uint16_t dwell = 0);
    /// Appends indices to the live FIFO. @return how many entries it holds now
    std::uint16_t push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell);
    void start(std::uint16_t first, std::uint16_t length, std::uint16_t loops);
    /// How long the board plays on without a sign of life from here; 0: for ever.
    void set_watchdog(std::uint16_t milliseconds);
    void write(std::uint32_t address, const Bytes& bytes);
    Bytes read(std::uint32_t address, std::uint16_t bytes);

    /// One request and its reply. After LinkLost it begins a new session first.
    Reply request(Request request);
    /// Many requests in a window; replies in order.
    /// @param progress  told the fraction done after each acknowledgement
    std::vector<Reply> pipeline(std::vector<Request> requests, const Progress& progress = {});

    /// Queues a request and tells of its reply, whose data is empty for a command without, from within wait().
    void submit(Request request, std::function<void(const Reply&)> done = {});
    /// Sends what the window allows of what is queued, without waiting for an answer.
    void flush() { transmit(); }
    /// Exchanges bytes with the board until at most so many requests are unanswered.
    void wait(std::size_t most_unanswered = 0);
    [[nodiscard]] std::size_t unanswered() const { return queue_.size(); }

    [[nodiscard]] std::uint64_t retransmissions() const { return retransmissions_; }
    /// How long to wait for an answer before sending again. Each answer which shows that that was too early doubles it,
    /// up to `most`: a simulated board may be slow.
    void set_patience(std::chrono::microseconds patience, std::chrono::microseconds most = {}) {
        patience_ = least_patience_ = patience;
        most_patience_ = std::max(patience, most);
    }

private:
    struct Pending {
        Request request;
        std::function<void(const Reply&)> done;
    };
    /// A frame that was sent and whose reply, if it gets one, is still to come. Replies come in the order of frames.
    struct Sent {
        std::uint8_t number;
        unsigned round;
    };

    void transmit();
    void take(const Reply& reply);
    void finish(const Reply& reply);
    void send_again();
    void forget();

    Transport& transport_;
    ReplyDecoder decoder_;
    std::deque<Pending> queue_;
    std::uint8_t next_ = 0;     // sequence number of the queue's first
    std::size_t sent_ = 0;      // of the queue, in this round
    std::size_t farthest_ = 0;  // of the queue, in any
    std::deque<Sent> on_line_;
    unsigned round_ = 0;  // a new one begins when frames are sent again
    unsigned tries_ = 0, strange_ = 0;
    bool in_doubt_ = false;  // whether what was sent last was applied: only a new session makes the numbers certain
    std::size_t most_asking_ = 1;  // frames under way that have the board send data, which wait in it meanwhile
    std::chrono::microseconds least_patience_{50'000}, patience_ = least_patience_, most_patience_ = least_patience_;
    std::uint64_t retransmissions_ = 0;
};

}  // namespace haptogram::link
