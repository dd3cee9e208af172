// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Vsync_tile_bench.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>
#include <vector>

#include "bench.hpp"

/// rtl/time/carrier_sync.v, sync_number.v and period_count.v of one master and its slaves, with clocks of their own.
namespace sync_boards {

constexpr int period = PARAMETER_PERIOD_CLOCKS;

/// A board: the modules, and a counter of clocks in the place of its player. Times are in clocks of 0 ppm.
struct Tile {
    Bench<Vsync_tile_bench> bench;
    double clock_length = 1.0, next = 0.0;
    int place = 0;        // clock of the cycle
    int length = 0;       // clocks since the cycle began
    double begun = -1e9;  // when that was

    void reset(int role, double ppm) {
        bench->i_role = role;
        bench->i_sync = bench->i_last = bench->i_set = 0;
        bench->i_number = 0;
        bench.reset();
        set_ppm(ppm);
        next = bench.number(0, 1000) * 0.001;
        place = bench.number(0, period - 1);
    }
    void set_ppm(double ppm) { clock_length = 1.0 / (1.0 + ppm * 1e-6); }
    /// @return whether a cycle begins with this clock
    bool clock(bool level) {
        bench->i_sync = level;
        bench->i_last = place == period - 1;
        // Half as many evaluations as bench.clock() has: the clock falls together with the inputs' change.
        bench->eval();
        const bool ends = bench->o_ends, last = bench->i_last;
        bench->clk = 1;
        bench->eval();
        bench->clk = 0;
        bench->i_set = 0;
        place = ends ? 0 : last ? place : place + 1;
        next += clock_length;
        return ends;
    }
};

/// The first tile is the master.
struct Boards {
    std::vector<Tile> tiles;
    std::deque<std::pair<double, bool>> wire;  // changes, as they arrive at the slaves
    bool sent = false, level = false;
    double widen = 0.0;  // the wire's next fall comes so much later

    explicit Boards(std::size_t count) : tiles(count) {
        for (std::size_t i = 0; i < count; ++i) tiles[i].reset(i == 0 ? 1 : 2, tiles[0].bench.number(-50, 50));
    }
    void set_master(std::uint64_t number) {
        tiles[0].bench->i_set = 1;
        tiles[0].bench->i_number = number;
    }
    /// Runs so many of the master's cycles, and calls `clocked(tile, when, begins)` after each clock of any tile.
    template <class Clocked>
    void run(std::uint64_t cycles, const Clocked& clocked) {
        for (std::uint64_t begun = 0; begun < cycles;) {
            std::size_t i = 0;
            for (std::size_t k = 1; k < tiles.size(); ++k)
                if (tiles[k].next < tiles[i].next) i = k;
            Tile& tile = tiles[i];
            while (!wire.empty() && wire.front().first <= tile.next) level = wire.front().second, wire.pop_front();
            const double now = tile.next;
            const bool begins = tile.clock(level);
            if (i == 0) {
                begun += begins ? 1U : 0U;
                const bool high = tile.bench->o_sync != 0;
                if (high != sent) wire.emplace_back(now + 0.2 + (high ? 0.0 : std::exchange(widen, 0.0)), high);
                sent = high;
            }
            clocked(i, now, begins);
        }
    }
};

// To be in step takes period / 8 cycles of seeking and 512 of learning; a number, two messages of 64 and the rest of
// one.
constexpr int until_in_step = period / 8 + 100 + 512, until_numbered = 200;

}  // namespace sync_boards
