// SPDX-License-Identifier: Apache-2.0
// A serial line in a given time with a board of a hundred lines at its end, for tests of threads and latencies.
#pragma once
#include <algorithm>
#include <atomic>
#include <boost/crc.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <vector>

#include "haptogram/link/frame.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::test {

using link::Bytes;
using link::Clock;

/// What a device does of which the link must take care: sessions and sequence numbers, memories and their digests,
/// outputs and their watchdog. Its live FIFO plays everything at once.
class FakeDevice {
public:
    struct Taken {
        interface::Command command;
        Clock::Time when;
        bool applied;
    };

    /// That tests plant, to see whether they are noticed.
    struct Faults {
        Clock::Time stop{0}, watchdog{0};  ///< for so long the outputs stay on that are to go off
    };
    FakeDevice() = default;
    explicit FakeDevice(Faults faults) : faults_(faults) {}

    /// A frame whose last byte arrived `when`; damaged ones get no answer. @return the reply, COBS-encoded
    Bytes take(std::span<const std::uint8_t> code, Clock::Time when) {
        const std::lock_guard lock(mutex_);
        const auto frame = link::cobs_decode(code);
        if (!frame || frame->size() < 4 || link::crc16(*frame) != 0) return {};
        using interface::Command;
        using interface::Status;
        const std::uint8_t sequence = (*frame)[0];
        const auto command = static_cast<Command>((*frame)[1]);
        const Bytes payload(frame->begin() + 2, frame->end() - 2);
        bite(when);
        const bool copy = command == Command::identify && in_session_ && sequence == session_;
        if (command == Command::identify && !copy) {
            session_ = expected_ = sequence;
            in_session_ = true;
        }
        const auto ahead = static_cast<std::uint8_t>(sequence - expected_);
        Status status = copy                                          ? Status::repeated
                        : !in_session_ || (ahead != 0 && ahead < 128) ? Status::out_of_order
                        : ahead != 0                                  ? Status::repeated
                        : refuses(command, payload)                   ? Status::bad_index
                                                                      : Status::ok;
        const bool acts_at_once = command == Command::disable || command == Command::stop;
        const bool applied = status == Status::ok;
        if (applied || acts_at_once) apply(command, payload, when);
        if (applied) ++expected_;
        if (applied && command != Command::identify) {
            if (enabled_) longest_silence_ = std::max(longest_silence_, when - alive_);
            alive_ = when;
        }
        log_.push_back({command, when, applied || acts_at_once});
        Bytes reply = {sequence,
                       static_cast<std::uint8_t>(static_cast<unsigned>(command) | 0x80U),
                       static_cast<std::uint8_t>(status),
                       expected_,
                       0,
                       0};
        if (applied || status == Status::repeated) {
            const Bytes data = data_of(command, payload);
            reply.insert(reply.end(), data.begin(), data.end());
        }
        const std::uint16_t crc = link::crc16(reply);
        reply.push_back(static_cast<std::uint8_t>(crc >> 8));
        reply.push_back(static_cast<std::uint8_t>(crc));
        Bytes out = link::cobs_encode(reply);
        out.push_back(0);
        return out;
    }

    void reset() {
        const std::lock_guard lock(mutex_);
        in_session_ = enabled_ = false;
    }
    [[nodiscard]] bool enabled() const {
        const std::lock_guard lock(mutex_);
        return enabled_;
    }
    /// When the outputs went off last, as seen now.
    [[nodiscard]] Clock::Time off_at(Clock::Time now) {
        const std::lock_guard lock(mutex_);
        bite(now);
        return off_at_;
    }
    /// When something new was heard last, and the longest time without, while outputs were on.
    [[nodiscard]] Clock::Time heard_at() const {
        const std::lock_guard lock(mutex_);
        return alive_;
    }
    [[nodiscard]] Clock::Time longest_silence() const {
        const std::lock_guard lock(mutex_);
        return longest_silence_;
    }
    [[nodiscard]] unsigned trips() const {
        const std::lock_guard lock(mutex_);
        return trips_;
    }
    [[nodiscard]] std::vector<Taken> log() const {
        const std::lock_guard lock(mutex_);
        return log_;
    }
    [[nodiscard]] std::uint16_t watchdog_ms() const {
        const std::lock_guard lock(mutex_);
        return watchdog_ms_;
    }

private:
    static std::uint32_t address_of(const Bytes& p) {
        return static_cast<std::uint32_t>(p[0] | p[1] << 8 | p[2] << 16) | static_cast<std::uint32_t>(p[3]) << 24;
    }
    static bool refuses(interface::Command command, const Bytes& payload) {
        return command == interface::Command::select && (payload[0] | payload[1] << 8) > 400;
    }
    void bite(Clock::Time now) {
        const Clock::Time bites = alive_ + std::chrono::milliseconds(watchdog_ms_) + faults_.watchdog;
        if (!enabled_ || watchdog_ms_ == 0 || now <= bites) return;
        enabled_ = false;
        off_at_ = bites;
        ++trips_;
    }
    void apply(interface::Command command, const Bytes& payload, Clock::Time when) {
        if (command == interface::Command::enable) enabled_ = true;
        if (command == interface::Command::disable && std::exchange(enabled_, false)) off_at_ = when + faults_.stop;
        if (command == interface::Command::watchdog)
            watchdog_ms_ = static_cast<std::uint16_t>(payload[0] | payload[1] << 8);
        if (command == interface::Command::write)
            for (std::size_t i = 4; i < payload.size(); ++i)
                memory_[address_of(payload) + static_cast<std::uint32_t>(i) - 4] = payload[i];
    }
    Bytes data_of(interface::Command command, const Bytes& payload) {
        Bytes data;
        const auto word = [&](unsigned value) {
            data.push_back(static_cast<std::uint8_t>(value));
            data.push_back(static_cast<std::uint8_t>(value >> 8));
        };
        using interface::Command;
        if (command == Command::identify) {
            data.assign(16, 0);
            std::ranges::copy(interface::name, data.begin());
            for (const unsigned value : {unsigned{interface::version_major} << 8, 100U, 400U, 1024U, 256U,
                                         8U << 8 | 16U, 50'000'000U & 0xffffU, 50'000'000U >> 16, 15U, 214U, 5U, 999U,
                                         128U, 50'000'000U & 0xffffU, 50'000'000U >> 16})
                word(value);
            data.resize(2 * interface::identity_words, 0);  // none of what boards may have
        } else if (command == Command::status) {
            for (const unsigned value :
                 {enabled_ ? 1U : 0U, 0U, 0U, 0U, 0U, 0U, 0U, trips_, 0U, 0U, unsigned{watchdog_ms_}, 0U})
                word(value);
            data.resize(2 * interface::status_untimed_words, 0);
        } else if (command == Command::digest || command == Command::read) {
            Bytes held(static_cast<std::size_t>(payload[4] | payload[5] << 8));
            for (std::size_t i = 0; i < held.size(); ++i)
                held[i] = memory_[address_of(payload) + static_cast<std::uint32_t>(i)];
            if (command == Command::read) return held;
            boost::crc_32_type crc;
            crc.process_bytes(held.data(), held.size());
            word(crc.checksum() & 0xffffU);
            word(crc.checksum() >> 16);
        }
        return data;
    }

    mutable std::mutex mutex_;
    std::map<std::uint32_t, std::uint8_t> memory_;
    std::vector<Taken> log_;
    Faults faults_;
    Clock::Time alive_{}, off_at_{}, longest_silence_{};
    unsigned trips_ = 0;
    std::uint16_t watchdog_ms_ = 500;
    std::uint8_t expected_ = 0, session_ = 0;  // the next frame's number, and that of the session's identify
    bool in_session_ = false, enabled_ = false;
};

/// The line: every byte takes ten bits' time. Bytes wait in a buffer of the operating system, from which they can be
/// taken back, and in one of the chip, from which they cannot.
class TimedLine final : public link::Transport {
public:
    struct Settings {
        double baud = 1'000'000;
        std::size_t chip = 128;                    ///< bytes that cannot be taken back
        std::size_t system = 4096;                 ///< bytes that fit before a write has to wait
        unsigned lose_one_in = 0;                  ///< bytes, in both directions; 0: none
        std::shared_ptr<std::atomic<bool>> cut{};  ///< the cable is pulled while it is true
    };

    TimedLine(FakeDevice& device, const Settings& settings, Clock& clock)
        : device_(device), settings_(settings), clock_(clock) {}

    [[nodiscard]] Clock& clock() override { return clock_; }

    void write(std::span<const std::uint8_t> bytes) override {
        require_cable();
        for (const std::uint8_t byte : bytes) {
            while (out_.size() > settings_.system) {
                clock_.rest_until(out_.front().when);
                run();
            }
            free_ = std::max(free_, clock_.now()) + byte_time();
            out_.push_back({byte, free_});
        }
    }

    std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        const auto deadline = clock_.now() + patience;
        for (;;) {
            require_cable();
            run();
            Bytes arrived;
            while (!in_.empty() && in_.front().when <= clock_.now()) {
                arrived.push_back(in_.front().byte);
                in_.pop_front();
            }
            if (!arrived.empty() || clock_.now() >= deadline) return arrived;
            clock_.rest_until(std::min({deadline, end_of_frame(in_), end_of_frame(out_)}));
        }
    }

    void discard_output() override {
        run();
        if (out_.size() > settings_.chip) out_.resize(settings_.chip);
        free_ = out_.empty() ? clock_.now() : out_.back().when;
    }

private:
    struct Byte {
        std::uint8_t byte = 0;
        Clock::Time when{};
    };

    [[nodiscard]] Clock::Time byte_time() const { return Clock::time(10.0 / settings_.baud); }
    static Clock::Time end_of_frame(const std::deque<Byte>& bytes) {
        const auto end = std::ranges::find(bytes, 0, &Byte::byte);
        return end != bytes.end() ? end->when : bytes.empty() ? Clock::Time::max() : bytes.back().when;
    }
    bool lost() { return settings_.lose_one_in != 0 && g_() % settings_.lose_one_in == 0; }
    void require_cable() const {
        if (settings_.cut && *settings_.cut) throw link::LinkLost("line", "the port is gone (pulled)");
    }

    void run() {
        while (!out_.empty() && out_.front().when <= clock_.now()) {
            const Byte next = out_.front();
            out_.pop_front();
            if (lost()) continue;
            if (next.byte != 0) {
                frame_.push_back(next.byte);
                continue;
            }
            Clock::Time when = std::max(next.when, in_.empty() ? next.when : in_.back().when);
            for (const std::uint8_t byte : device_.take(frame_, next.when)) {
                when += byte_time();
                if (!lost()) in_.push_back({byte, when});
            }
            frame_.clear();
        }
    }

    FakeDevice& device_;
    Settings settings_;
    Clock& clock_;
    std::mt19937 g_{7};
    std::deque<Byte> out_, in_;
    Clock::Time free_{};  // when the line has sent what was written
    Bytes frame_;
};

}  // namespace haptogram::test
