// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
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
    explicit Client(std::unique_ptr<Transport> transport) : owned_(std::move(transport)), transport_(*owned_) {}

    /// Starts a session; nothing else is answered before it.
    /// @throws Error{device} also when what answers is no Haptogram
    Identity identify();
    /// The same, but returns at once; exchange() then waits for the answer, and tells of it. It throws what identify()
    /// does.
    void begin(std::function<void()> begun);
    [[nodiscard]] const Identity& identity() const override { return identity_; }
    /// As it came, for who takes it apart himself.
    [[nodiscard]] const Bytes& identity_block() const { return identity_block_; }

    /// Turns the outputs off ahead of everything, and needs no session for it: drops what is queued, takes back what
    /// has not left the port, and sends disable and stop, which act whatever their numbers. Returns at once; exchange()
    /// then repeats them, and with a break of the line, until is_off() is known.
    void shut_off();
    /// Whether the device has confirmed a shut_off(). Unknown while it may still do so, false when there was none.
    [[nodiscard]] std::optional<bool> is_off() const;
    /// shut_off(), and the waiting for it. @return whether it was confirmed
    bool turn_off() override;
    /// Ends a shut_off() once is_off() is known: one that was not confirmed with a break of the line.
    /// @return whether it was confirmed
    bool end_shut_off();

    void submit(Request request, std::function<void(const Reply&)> done = {}) override;
    /// The same, but a refusal is told to `refused` instead of thrown, and what is queued behind is still carried out.
    void submit(Request request, std::function<void(const Reply&)> done, std::function<void(const Error&)> refused);
    void tell(Request request) override;
    void flush() override {
        transmit();
        transport_.flush();
    }
    void wait(std::size_t most_unanswered = 0) override;
    /// One step of wait(): sends what the window allows, and takes what arrives within `at_most`.
    void exchange(std::chrono::microseconds at_most);
    [[nodiscard]] std::size_t unanswered() const override { return queue_.size() - kept_alive_; }
    /// Answers that came, also to what was sent twice: by this a slow device differs from a silent one.
    [[nodiscard]] std::uint64_t answers() const { return answers_; }
    /// How many times longer than usual the device may take, as its answers have shown: 1 for a real one.
    [[nodiscard]] unsigned slowness() const { return static_cast<unsigned>(patience_ / least_patience_); }
    void drop() override;
    /// How many frames may be under way.
    [[nodiscard]] unsigned window() const { return transport_.window(); }

    [[nodiscard]] std::uint64_t retransmissions() const override { return retransmissions_; }
    [[nodiscard]] Clock& clock() override { return transport_.clock(); }
    void keep_alive_every(std::chrono::milliseconds pause) override { keep_alive_pause_ = pause; }
    /// In place of the transport's patience and the policy's limit.
    void set_patience(std::chrono::microseconds patience, std::chrono::microseconds most = {}) {
        patience_ = least_patience_ = patience;
        most_patience_ = std::max(patience, most);
    }
    /// The next session begins with this number instead of a random one, for who speaks with raw frames beside it.
    void begin_at(std::uint8_t number) { next_ = static_cast<std::uint8_t>(number + 128); }
    /// Looked at wherever something is waited for. When the user asks to end, Interrupted is thrown, once. What is done
    /// after it is to clean up: it may ask and write, but not enable, and a device that is silent then is soon lost.
    void set_interrupt(Interrupt interrupt);

protected:
    void make_ready() override;

private:
    struct Pending {
        Request request;
        std::function<void(const Reply&)> done;
        std::function<void(const Error&)> refused;
        bool keeps_alive = false;      ///< sent by the client itself
        std::optional<Reply> reply{};  ///< waits for those before it
    };
    /// A frame that was sent and whose reply, if it gets one, is still to come. Replies come in the order of frames.
    struct Sent {
        std::uint8_t number;
        unsigned round;
        Clock::Time at;
    };
    /// A shut_off() that is not confirmed yet.
    struct Off {
        std::uint8_t number = 0;  ///< of disable; that of stop is the next one
        bool disabled = false, stopped = false;
        unsigned rounds = 0;
        bool broken = false;  ///< a break was sent
        Clock::Time said{};
    };

    /// Whether an answer with data is still to come.
    [[nodiscard]] static bool asks(const Pending& pending) {
        return !pending.reply && replies(pending.request.command);
    }
    [[nodiscard]] unsigned interrupts() const { return interrupt_ ? interrupt_() : 0; }
    void heed_interrupt();
    std::chrono::microseconds hear(std::chrono::microseconds at_most, std::vector<Reply>& arrived);
    void transmit();
    void say_alive();
    void say_first_again();
    void repeat(std::size_t place);
    void take(const Reply& reply);
    void require_good(const Reply& reply, const Request& request);
    void pop();
    void refuse(const Reply& reply);
    void finish_answered();
    void finish(const Reply& reply);
    void begin_round(bool late);
    void begin_anew();
    void require_progress();
    void send_again_soon();
    [[noreturn]] void lose(const std::string& why);
    void forget();
    [[nodiscard]] bool shutting_off() const { return off_ && !is_off(); }
    void say_off();
    void send_break();
    void listen_for_off(std::chrono::microseconds at_most);

    std::unique_ptr<Transport> owned_;
    Transport& transport_;
    Identity identity_;
    Bytes identity_block_;
    ReplyDecoder decoder_;
    std::deque<Pending> queue_;
    std::size_t kept_alive_ = 0;  // of the queue: what keeps_alive
    // Sessions begin anywhere, so that late replies to a program that was killed match nothing.
    std::uint8_t next_ = static_cast<std::uint8_t>(std::random_device()());  // sequence number of the queue's first
    std::uint8_t session_ = 0;                                               // number of the identify that began it
    std::size_t sent_ = 0;                                                   // of the queue, in this round
    std::size_t farthest_ = 0;                                               // of the queue, in any
    std::deque<Sent> on_line_;
    unsigned round_ = 0;          // a new one begins when frames are sent again
    unsigned first_round_ = 0;    // in which the queue's first became that
    bool round_is_late_ = false;  // it began because nothing was answered
    unsigned tries_ = 0, strange_ = 0;
    bool sent_again_ = false;  // for an answer that showed a loss, within this patience
    bool in_doubt_ = true;     // whether what was sent last was applied: only a new session makes the numbers certain
    std::size_t most_asking_ = 1;  // frames under way whose replies carry data, for which the device keeps room
    std::chrono::microseconds least_patience_ = transport_.patience(), patience_ = least_patience_;
    std::chrono::microseconds most_patience_ = std::max<std::chrono::microseconds>(
        patience_, std::chrono::milliseconds(interface::link_policy::most_patience_ms));
    std::chrono::microseconds waited_{0};  // since a request was finished or sent again
    std::chrono::microseconds stuck_{0};   // since a request was finished
    std::uint64_t heard_ = 0;              // bytes since a request was finished
    std::uint64_t retransmissions_ = 0, answers_ = 0;
    std::optional<Off> off_;
    Interrupt interrupt_;
    bool heeded_ = false;    // Interrupted was thrown
    bool given_up_ = false;  // while cleaning up
    std::chrono::milliseconds keep_alive_pause_{0};
    std::chrono::nanoseconds said_{0};  // when something new was sent last
    bool first_again_ = false;          // the first of the queue was sent once more
};

/// Shuts several devices off: all of them blind at first, and then waits for each.
/// @return of each, whether it was confirmed
std::vector<bool> shut_off(std::span<Client* const> devices);

}  // namespace haptogram::link
