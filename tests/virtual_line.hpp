// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>

#include "board.hpp"
#include "haptogram/link/transport.hpp"

namespace haptogram::test {

/// The line to a simulated board that lives in a given time, together with others: the board is taken along when
/// somebody looks at its line.
class VirtualLine final : public link::Transport {
public:
    /// @param begun  when the board was switched on
    VirtualLine(sim::Board& board, link::Clock& clock, link::Clock::Time begun)
        : board_(board), clock_(clock), begun_(begun) {}
    VirtualLine(sim::Board& board, link::Clock& clock) : VirtualLine(board, clock, clock.now()) {}

    void write(std::span<const std::uint8_t> bytes) override {
        catch_up();
        board_.send(bytes);
    }
    [[nodiscard]] std::vector<std::uint8_t> read(std::chrono::microseconds patience) override {
        constexpr std::chrono::microseconds look{50};
        const link::Clock::Time until = clock_.now() + patience;
        for (catch_up(); board_.received() == 0 && clock_.now() < until; catch_up())
            clock_.rest_until(std::min<link::Clock::Time>(until, clock_.now() + look));
        return board_.receive();
    }
    [[nodiscard]] link::Clock& clock() override { return clock_; }
    /// Lets the board do all that it does until now.
    void catch_up() {
        const double clocks = clock_.seconds_since(begun_) * board_.parameters().clock_hz;
        if (const auto now = static_cast<std::uint64_t>(clocks); now > board_.now()) board_.run(now - board_.now());
    }

private:
    sim::Board& board_;
    link::Clock& clock_;
    const link::Clock::Time begun_;
};

}  // namespace haptogram::test
