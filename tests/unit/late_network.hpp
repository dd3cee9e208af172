// SPDX-License-Identifier: Apache-2.0
// A network in a given time that delays each datagram by another time, so that they overtake each other.
#pragma once
#include <functional>

#include "timed_line.hpp"

namespace haptogram::test {

class LateNetwork final : public link::Transport {
public:
    struct Settings {
        std::chrono::microseconds most_late{0};  ///< of a datagram, at random
        /// Of a datagram from the host: after how long a copy of it comes, too.
        std::function<std::optional<std::chrono::milliseconds>(std::span<const std::uint8_t>)> copies = [](auto) {
            return std::nullopt;
        };
        std::mt19937::result_type seed = 7;
    };
    LateNetwork(FakeDevice& device, Settings settings, Clock& clock)
        : device_(device), settings_(std::move(settings)), clock_(clock), g_(settings_.seed) {}

    [[nodiscard]] Clock& clock() override { return clock_; }
    [[nodiscard]] std::chrono::microseconds patience() const override {
        return std::chrono::milliseconds(interface::network::patience_ms);
    }
    [[nodiscard]] unsigned rounds() const override {
        return unsigned{interface::link_policy::patience_ms} / interface::network::patience_ms;
    }
    [[nodiscard]] unsigned window() const override { return interface::network::window; }

    void write(std::span<const std::uint8_t> bytes) override {
        if (bytes.size() < 2) return;  // a zero by itself
        ++sent_;
        const Bytes frame(bytes.begin(), bytes.end() - 1);
        to_.emplace(clock_.now() + late(), frame);
        if (const auto copy = settings_.copies(frame)) to_.emplace(clock_.now() + *copy, frame);
    }
    std::vector<std::uint8_t> read(std::chrono::microseconds at_most) override {
        for (const Clock::Time until = clock_.now() + at_most;;) {
            run();
            Bytes arrived;
            for (; !from_.empty() && from_.begin()->first <= clock_.now(); from_.erase(from_.begin()))
                arrived.insert(arrived.end(), from_.begin()->second.begin(), from_.begin()->second.end());
            if (!arrived.empty() || clock_.now() >= until) return arrived;
            Clock::Time next = until;
            if (!to_.empty()) next = std::min(next, to_.begin()->first);
            if (!from_.empty()) next = std::min(next, from_.begin()->first);
            clock_.rest_until(next);
        }
    }
    /// Datagrams of the host.
    [[nodiscard]] unsigned sent() const { return sent_; }

private:
    Clock::Time late() {
        return std::chrono::microseconds(settings_.most_late.count() == 0 ? 0 : g_() % settings_.most_late.count());
    }
    void run() {
        for (; !to_.empty() && to_.begin()->first <= clock_.now(); to_.erase(to_.begin())) {
            const auto& [when, frame] = *to_.begin();
            if (const Bytes answer = device_.take(frame, when); !answer.empty()) from_.emplace(when + late(), answer);
        }
    }

    FakeDevice& device_;
    const Settings settings_;
    Clock& clock_;
    std::mt19937 g_;
    std::multimap<Clock::Time, Bytes> to_, from_;
    unsigned sent_ = 0;
};

}  // namespace haptogram::test
