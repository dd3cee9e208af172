// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>

#include "pace.hpp"

namespace haptogram::sim {
namespace {

/// A board that is simulated with a clock of the test's own: how long computing takes is the test's choice.
struct Simulated {
    Pace::Clock::time_point now{};
    Pace pace{0.01, now};
    double simulated_s = 0.0, longest_leap_s = 0.0;

    void pass(double seconds) {
        now += std::chrono::duration_cast<Pace::Clock::duration>(std::chrono::duration<double>(seconds));
    }
    /// Catches up with real time, at `speed` times real time.
    void catch_up(double speed) {
        const double leap_s = std::max(0.0, -pace.ahead_s(simulated_s, now));
        simulated_s += leap_s;
        pass(leap_s / speed);
        pace.give_up(simulated_s, now);
        longest_leap_s = std::max(longest_leap_s, leap_s);
    }
};

}  // namespace

TEST_CASE("a board that is simulated too slowly runs slower than the wall's clock, not in longer and longer leaps",
          "[pace]") {
    Simulated board;
    while (board.pace.wall_s(board.now) < 60.0) {
        board.pass(1e-4);
        board.catch_up(0.8);
    }
    CHECK(board.longest_leap_s <= 0.0102);
    CHECK(board.simulated_s > 0.75 * 60.0);
    CHECK(board.simulated_s < 0.81 * 60.0);
}

TEST_CASE("a board that is simulated fast enough keeps real time, through pauses too", "[pace]") {
    Simulated board;
    while (board.pace.wall_s(board.now) < 10.0) {
        board.pass(1e-4);
        board.catch_up(5.0);
    }
    board.pass(0.6);  // the host is silent: this a board's watchdog counts
    board.catch_up(5.0);
    CHECK(board.longest_leap_s >= 0.6);
    CHECK(-board.pace.ahead_s(board.simulated_s, board.now) <= 0.0101);
    CHECK(board.simulated_s > board.pace.wall_s(board.now) - 0.13);
}

}  // namespace haptogram::sim
