// SPDX-License-Identifier: Apache-2.0
// A board in memory that keeps the rules of rtl/INTERFACE.md, behind a line that lies as a test tells it to. Time is
// the line's own: a wait for nothing takes as long as it may, and no time of the machine.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include "haptogram/link/frame.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::test {

using link::Bytes;
using link::Reply;
using std::chrono::nanoseconds;

/// An identity block of a tile of 100 channels. @param change  of its words, by their number
inline Bytes identity_block(const std::vector<std::pair<unsigned, std::uint16_t>>& change = {}) {
    std::vector<std::uint16_t> words(interface::identity_words);
    for (std::size_t i = 0; i < interface::name.size(); ++i)
        words[i / 2] =
            static_cast<std::uint16_t>(words[i / 2] | static_cast<unsigned char>(interface::name[i]) << (8 * (i % 2)));
    words[8] = static_cast<std::uint16_t>(interface::version_major << 8);
    const std::uint16_t rest[] = {100, 400, 1024, 256, 8 << 8 | 16, 50'000'000 & 0xffff, 50'000'000 >> 16,
                                  15,  214, 5,    999, 128,         50'000'000 & 0xffff, 50'000'000 >> 16};
    std::copy(std::begin(rest), std::end(rest), words.begin() + 9);
    for (const auto& [word, value] : change) words[word] = value;
    Bytes block;
    for (const std::uint16_t word : words)
        for (const unsigned shift : {0U, 8U}) block.push_back(static_cast<std::uint8_t>(word >> shift));
    return block;
}

inline Bytes reply_frame(const Reply& r) {
    Bytes frame = {r.sequence,
                   static_cast<std::uint8_t>(static_cast<unsigned>(r.command) | 0x80U),
                   static_cast<std::uint8_t>(r.status),
                   r.expected,
                   static_cast<std::uint8_t>(r.live_level),
                   static_cast<std::uint8_t>(r.live_level >> 8)};
    frame.insert(frame.end(), r.data.begin(), r.data.end());
    const std::uint16_t crc = link::crc16(frame);
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    frame.push_back(static_cast<std::uint8_t>(crc));
    Bytes code = link::cobs_encode(frame);
    code.push_back(0);
    return code;
}

class LyingBoard final : public link::Transport {
public:
    using Command = interface::Command;
    using Code = interface::Status;
    struct Heard {
        Command command;
        std::uint8_t number;
        nanoseconds when;
    };

    // What it does.
    Bytes identity = identity_block();
    std::function<std::vector<Reply>(Reply)> lie = [](Reply reply) { return std::vector{std::move(reply)}; };
    std::function<bool()> hears = [] { return true; };                  ///< whether the next frame arrives
    std::function<nanoseconds()> late = [] { return nanoseconds(0); };  ///< each way
    std::function<Bytes()> babbles{};  ///< bytes of somebody else, whenever nothing else is there
    std::function<void(const Heard&)> on_frame{};
    std::chrono::microseconds its_patience = std::chrono::milliseconds(300);
    std::uint16_t mode = 1, present = 1, role = 0;
    bool timed = false;
    std::uint64_t period = 0;

    // What has become of it.
    std::vector<Heard> heard;
    bool enabled = false;
    unsigned trips = 0, breaks = 0;
    std::uint16_t watchdog_ms = 500;
    nanoseconds time{0};

    void write(std::span<const std::uint8_t> bytes) override {
        for (const std::uint8_t byte : bytes) {
            if (byte != 0) {
                frame_.push_back(byte);
                continue;
            }
            if (!frame_.empty() && hears()) {
                last_in_ = std::max(last_in_, time + late());
                in_.push_back({last_in_, frame_});
            }
            frame_.clear();
        }
        run(time);
    }
    std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        const nanoseconds until = time + patience;
        for (;;) {
            nanoseconds next = until;
            if (!in_.empty()) next = std::min(next, in_.front().first);
            if (!out_.empty()) next = std::min(next, out_.front().first);
            run(std::max(next, time));
            if (!out_.empty() && out_.front().first <= time) {
                Bytes bytes = std::move(out_.front().second);
                out_.pop_front();
                time += std::chrono::microseconds(50);
                return bytes;
            }
            if (babbles) {
                run(std::min(until, time + std::chrono::milliseconds(1)));
                return babbles();
            }
            if (time >= until) return {};
        }
    }
    void send_break() override {
        ++breaks;
        enabled = false;
    }
    [[nodiscard]] link::Clock& clock() override { return clock_; }
    [[nodiscard]] std::chrono::microseconds patience() const override { return its_patience; }
    /// Time in which the host does something else.
    void pass(nanoseconds how_long) { run(time + how_long); }
    [[nodiscard]] bool heard_of(Command command) const {
        return std::ranges::find(heard, command, &Heard::command) != heard.end();
    }

private:
    class Its final : public link::Clock {
    public:
        explicit Its(LyingBoard& board) : board_(board) {}
        [[nodiscard]] Time now() const override { return board_.time; }
        void rest_until(Time until) override { board_.run(std::max(until, board_.time)); }

    private:
        LyingBoard& board_;
    };

    void run(nanoseconds until) {
        while (!in_.empty() && in_.front().first <= until) {
            time = std::max(time, in_.front().first);
            const Bytes code = std::move(in_.front().second);
            in_.pop_front();
            bite();
            take(code);
        }
        time = std::max(time, until);
        bite();
    }
    void bite() {
        if (!enabled || watchdog_ms == 0 || time - alive_ <= std::chrono::milliseconds(watchdog_ms)) return;
        enabled = false;
        ++trips;
    }
    void take(const Bytes& code) {
        const auto frame = link::cobs_decode(code);
        if (!frame || frame->size() < 4 || link::crc16(*frame) != 0) return;
        Reply reply{(*frame)[0], static_cast<Command>((*frame)[1]), Code::ok, 0, 0, {}};
        const Bytes payload(frame->begin() + 2, frame->end() - 2);
        heard.push_back({reply.command, reply.sequence, time});
        if (on_frame) on_frame(heard.back());
        if (reply.command == Command::identify) expected_ = reply.sequence, in_session_ = true;
        const auto ahead = static_cast<std::uint8_t>(reply.sequence - expected_);
        if (reply.command == Command::disable || reply.command == Command::stop) {
            if (reply.command == Command::disable) enabled = false;
        }
        if (!in_session_ || (ahead != 0 && ahead < 128))
            reply.status = Code::out_of_order;
        else if (ahead != 0)
            reply.status = Code::repeated;
        if (reply.status == Code::ok) {
            ++expected_;
            if (reply.command != Command::identify) alive_ = time;
            if (reply.command == Command::enable) enabled = true;
            if (reply.command == Command::watchdog)
                watchdog_ms = static_cast<std::uint16_t>(payload[0] | payload[1] << 8);
            if (reply.command == Command::sync) role = payload[0];
        }
        if (reply.status != Code::out_of_order) reply.data = data_of(reply.command, payload);
        reply.expected = expected_;
        for (const Reply& one : lie(std::move(reply))) {
            last_out_ = std::max(last_out_, time + late());
            out_.push_back({last_out_, reply_frame(one)});
        }
    }
    Bytes data_of(Command command, const Bytes& payload) const {
        if (command == Command::identify) return identity;
        if (command == Command::read) return Bytes(static_cast<std::size_t>(payload[4] | payload[5] << 8), payload[0]);
        if (command == Command::digest) return Bytes(4, 0);
        if (command != Command::status) return {};
        std::vector<std::uint16_t> words(timed ? interface::status_unstreamed_words : interface::status_untimed_words);
        words[0] = static_cast<std::uint16_t>((enabled ? 1 : 0) | mode << 1);
        words[1] = present;
        words[7] = static_cast<std::uint16_t>(trips);
        words[10] = watchdog_ms;
        words[14] = role;
        if (timed) words[18] = static_cast<std::uint16_t>(period);
        Bytes data;
        for (const std::uint16_t word : words)
            for (const unsigned shift : {0U, 8U}) data.push_back(static_cast<std::uint8_t>(word >> shift));
        return data;
    }

    Its clock_{*this};
    Bytes frame_;
    std::deque<std::pair<nanoseconds, Bytes>> in_, out_;
    nanoseconds last_in_{0}, last_out_{0}, alive_{0};
    std::uint8_t expected_ = 0;
    bool in_session_ = false;
};

}  // namespace haptogram::test
