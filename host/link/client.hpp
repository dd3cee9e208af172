// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "image/image.hpp"
#include "link/frame.hpp"
#include "link/transport.hpp"

namespace haptogram::link {

/// What a board says it is.
struct Identity {
    std::string name;
    unsigned version_major = 0, version_minor = 0;
    std::uint32_t channels = 0, records = 0, sequence_depth = 0, live_depth = 0;
    std::uint32_t timing_bits = 0, pulse_bits = 0, clock_hz = 0, features = 0, frame_bytes = 0;
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

/// Speaks to a board. Requests go out in a window, each is acknowledged, and what is lost is sent again from the first
/// missing one on; the board applies each exactly once and in order.
class Client {
public:
    explicit Client(Transport& transport) : transport_(transport) {}

    /// Starts a session. @throws Error{device} when nothing answers or what answers is no Haptogram
    Identity identify();
    BoardStatus status();
    void enable() { request({interface::Command::enable, {}}); }
    void disable() { request({interface::Command::disable, {}}); }
    void stop() { request({interface::Command::stop, {}}); }
    void select(std::uint16_t index, std::uint16_t dwell = 0);
    /// Appends indices to the live FIFO. @return how many entries it holds now. @throws Error{device} when they do not
    /// fit or one is out of range
    std::uint16_t push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell);
    void start(std::uint16_t first, std::uint16_t length, std::uint16_t loops);
    void set_watchdog(std::uint16_t milliseconds);
    void write(std::uint32_t address, const Bytes& bytes);
    Bytes read(std::uint32_t address, std::uint16_t bytes);

    /// Writes an image, a record a frame, and its sequence. The caller has checked that it fits (fits()).
    /// @param progress  told the fraction done after each acknowledgement
    void upload(const Image& image, const std::function<void(double)>& progress = {});

    /// Reads an image's places back. @return empty when they hold it, else the first difference in words
    std::string compare(const Image& image, const std::function<void(double)>& progress = {});

    /// One request and its reply. @throws Error{device} naming the command and the board's reason
    Reply request(const Request& request);
    /// Many requests in a window; replies in order.
    std::vector<Reply> pipeline(const std::vector<Request>& requests, const std::function<void(double)>& progress = {});

    [[nodiscard]] std::uint64_t retransmissions() const { return retransmissions_; }
    /// How long to wait for an answer before sending again. Each answer which says that that was too early doubles it,
    /// up to `most`: a simulated board may be slow.
    void set_patience(std::chrono::microseconds patience, std::chrono::microseconds most = {}) {
        patience_ = patience;
        most_patience_ = std::max(patience, most);
    }

private:
    Transport& transport_;
    ReplyDecoder decoder_;
    std::uint8_t next_ = 0;
    std::chrono::microseconds patience_{50'000};
    std::chrono::microseconds most_patience_ = patience_;
    std::uint64_t retransmissions_ = 0;
};

/// @throws Error{bad_input} saying why the image does not fit the board
void require_fits(const Image& image, const Identity& board, const std::string& where);

}  // namespace haptogram::link
