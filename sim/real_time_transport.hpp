// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>
#include <thread>

#include "board.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::sim {

/// The simulated serial line of a board that keeps real time, in whatever thread reads from it. The board stands still
/// while nobody does, and then catches up.
class RealTimeTransport final : public link::Transport {
public:
    explicit RealTimeTransport(Board& board) : board_(board) {}

    void write(std::span<const std::uint8_t> bytes) override {
        catch_up();
        board_.send(bytes);
    }

    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        const auto end = std::chrono::steady_clock::now() + patience;
        for (catch_up(); board_.received() == 0 && std::chrono::steady_clock::now() < end; catch_up())
            std::this_thread::sleep_for(std::min(patience, std::chrono::microseconds(100)));
        return board_.receive();
    }

    [[nodiscard]] std::chrono::nanoseconds now() const override {
        return std::chrono::steady_clock::now().time_since_epoch();
    }

private:
    void catch_up() {
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begun_;
        const auto due = static_cast<std::uint64_t>(passed.count() * board_.parameters().clock_hz);
        if (due > board_.now()) board_.run(due - board_.now());
    }

    Board& board_;
    std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

}  // namespace haptogram::sim
