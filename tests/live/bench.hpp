// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/link/client.hpp"
#include "haptogram/live/clock.hpp"
#include "reference_board.hpp"
#include "simulated_transport.hpp"

/// A reference board on its simulated line, whose clock is the loop's, and what its pins begin to play.
struct LiveBench {
    explicit LiveBench(std::string_view configuration) : board(configuration), line(board), client(line) {
        board.on_cycle_start([this](const haptogram::sim::CycleStart& c) {
            if (c.enabled && (starts.empty() || starts.back().second != c.index))
                starts.emplace_back(seconds(c.clock), c.index);
        });
        client.identify();
        clock = {[this] { return seconds(board.now()); },
                 [this](double until_s) {
                     const double clocks = until_s * board.parameters().clock_hz - static_cast<double>(board.now());
                     if (clocks > 0.0) board.run(static_cast<std::uint64_t>(clocks) + 1);
                 }};
    }
    [[nodiscard]] double seconds(std::uint64_t clocks) const {
        return static_cast<double>(clocks) / board.parameters().clock_hz;
    }

    haptogram::sim::ReferenceBoard board;
    haptogram::sim::SimulatedTransport line;
    haptogram::link::Client client;
    haptogram::live::Clock clock;
    std::vector<std::pair<double, std::uint16_t>> starts;  ///< changes of the record: when, and its index
};
