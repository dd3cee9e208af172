// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "board.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::sim {

/// The simulated serial line as a link::Transport: waiting for bytes runs the board's clock.
class SimulatedTransport : public link::Transport {
public:
    explicit SimulatedTransport(Board& board) : board_(board) {}

    void write(std::span<const std::uint8_t> bytes) override { board_.send(bytes); }

    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        const double clocks = static_cast<double>(patience.count()) * 1e-6 * board_.parameters().clock_hz;
        // What the host has written takes its time on the line; the waiting for an answer begins after it.
        while (!board_.line_idle() && board_.received() == 0) board_.run(64);
        board_.run_until([this] { return board_.received() > 0; }, static_cast<std::uint64_t>(clocks));
        return board_.receive();
    }

    [[nodiscard]] link::Clock& clock() override { return clock_; }
    /// Nothing else takes time from a simulated clock, so less patience is enough than on a line to another machine.
    [[nodiscard]] std::chrono::microseconds patience() const override { return std::chrono::milliseconds(50); }

private:
    class BoardClock final : public link::Clock {
    public:
        explicit BoardClock(Board& board) : board_(board) {}
        [[nodiscard]] Time now() const override {
            return Time(static_cast<std::int64_t>(1e9 * static_cast<double>(board_.now()) / clock_hz()));
        }
        void rest_until(Time until) override {
            const double left = seconds(until) * clock_hz() - static_cast<double>(board_.now());
            if (left > 0.0) board_.run(static_cast<std::uint64_t>(left) + 1);
        }

    private:
        [[nodiscard]] double clock_hz() const { return board_.parameters().clock_hz; }
        Board& board_;
    };

    Board& board_;
    BoardClock clock_{board_};
};

}  // namespace haptogram::sim
