// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "haptogram/link/commands.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::link {

/// Speaks to a device in the caller's thread, and sleeps while it waits. Requests go out in a window, each is
/// acknowledged, and what is lost is sent again from the first missing one on; the device applies each exactly once and
/// in order. How often and how soon things are sent again, and when a link counts as lost, is one policy for all hosts:
/// see "A line that loses bytes" in rtl/INTERFACE.md. example.cpp in this folder is a program of twenty lines.
class Client : public Commands {
public:
    explicit Client(Transport& transport) : transport_(transport) {}

    /// Starts a session; nothing else is answered before it.
    /// @throws Error{device} also when what answers is no Haptogram
    Identity identify();
    [[nodiscard]] const Identity& identity() const override { return identity_; }

    /// Turns the outputs off ahead of everything: drops what is queued, takes back what has not left the port, and
    /// sends disable and stop in a new session, because only the beginning of a session is taken whatever the line lost
    /// before it. Returns at once; wait(), or exchange() until nothing is unanswered, brings the confirmation.
    void shut_off();

    void submit(Request request, std::function<void(const Reply&)> done = {}) override;
    /// The same, but a refusal is told to `refused` instead of thrown, and what is queued behind is still carried out.
    void submit(Request request, std::function<void(const Reply&)> done, std::function<void(const Error&)> refused);
    void flush() override { transmit(); }
    void wait(std::size_t most_unanswered = 0) override;
    /// One step of wait(): sends what the window allows, and takes what arrives within `at_most`.
    void exchange(std::chrono::microseconds at_most);
    [[nodiscard]] std::size_t unanswered() const override { return queue_.size(); }
    void drop() override;

    [[nodiscard]] std::uint64_t retransmissions() const override { return retransmissions_; }
    /// In place of the transport's patience and the policy's limit.
    void set_patience(std::chrono::microseconds patience, std::chrono::microseconds most = {}) {
        patience_ = least_patience_ = patience;
        most_patience_ = std::max(patience, most);
    }
    /// Asked before each frame is sent; while it says true, none is.
    void set_hold(std::function<bool()> hold) { hold_ = std::move(hold); }

protected:
    explicit Client(std::unique_ptr<Transport> transport) : owned_(std::move(transport)), transport_(*owned_) {}
    void make_ready() override;

private:
    struct Pending {
        Request request;
        std::function<void(const Reply&)> done;
        std::function<void(const Error&)> refused;
    };
    /// A frame that was sent and whose reply, if it gets one, is still to come. Replies come in the order of frames.
    struct Sent {
        std::uint8_t number;
        unsigned round;
    };

    void transmit();
    void take(const Reply& reply);
    void refuse(const Reply& reply);
    bool finish_before(const Reply& reply, std::size_t place);
    void finish(const Reply& reply);
    void send_again();
    void forget();

    std::unique_ptr<Transport> owned_;
    Transport& transport_;
    Identity identity_;
    ReplyDecoder decoder_;
    std::deque<Pending> queue_;
    std::uint8_t next_ = 0;     // sequence number of the queue's first
    std::size_t sent_ = 0;      // of the queue, in this round
    std::size_t farthest_ = 0;  // of the queue, in any
    std::deque<Sent> on_line_;
    unsigned round_ = 0;  // a new one begins when frames are sent again
    unsigned tries_ = 0, strange_ = 0;
    bool in_doubt_ = false;  // whether what was sent last was applied: only a new session makes the numbers certain
    std::size_t most_asking_ = 1;  // frames under way whose replies carry data, for which the device keeps room
    std::chrono::microseconds least_patience_ = transport_.patience(), patience_ = least_patience_;
    std::chrono::microseconds most_patience_ = std::max<std::chrono::microseconds>(
        patience_, std::chrono::milliseconds(interface::link_policy::most_patience_ms));
    std::chrono::microseconds waited_{0};  // since something arrived or was sent again
    std::uint64_t retransmissions_ = 0;
    std::function<bool()> hold_;
};

}  // namespace haptogram::link
