// SPDX-License-Identifier: Apache-2.0
// rtl/carrier_sync.v, sync_number.v and period_count.v of one master and three slaves with clocks of their own. What is
// compared are numbers of periods, each in the middle of a period of its board.
#include <Vsync_tile_bench.h>

#include <array>
#include <cmath>
#include <deque>
#include <utility>

#include "bench.hpp"

namespace {

constexpr int period = PARAMETER_PERIOD_CLOCKS;

/// A board: the modules, and a counter of clocks in the place of its player.
struct Tile {
    Bench<Vsync_tile_bench> bench;
    double clock_length = 1.0, next = 0.0;
    int place = 0;  // clock of the cycle

    void reset(int role, double ppm) {
        bench->i_role = role;
        bench->i_sync = bench->i_last = bench->i_set = 0;
        bench->i_number = 0;
        bench.reset();
        clock_length = 1.0 / (1.0 + ppm * 1e-6);
        next = bench.number(0, 1000) * 0.001;
        place = bench.number(0, period - 1);
    }
    void clock(bool level) {
        bench->i_sync = level;
        bench->i_last = place == period - 1;
        bench->eval();
        const bool ends = bench->o_ends, last = bench->i_last;
        bench.clock();
        bench->i_set = 0;
        place = ends ? 0 : last ? place : place + 1;
        next += clock_length;
    }
};

struct Boards {
    std::array<Tile, 4> tiles;
    std::deque<std::pair<double, bool>> wire;  // changes, as they arrive at the slaves
    bool sent = false, level = false;
    double widen = 0.0;  // the wire's next fall comes so much later
    std::uint64_t compared = 0, wrong = 0, unnumbered = 0;

    Boards() {
        for (std::size_t i = 0; i < 4; ++i) tiles[i].reset(i == 0 ? 1 : 2, tiles[0].bench.number(-50, 50));
    }
    void set_master(std::uint64_t number) {
        tiles[0].bench->i_set = 1;
        tiles[0].bench->i_number = number;
    }
    /// Runs so many of the master's cycles; `numbered` is asked for each of the slaves.
    void run(int cycles) {
        for (int begun = 0; begun < cycles;) {
            std::size_t i = 0;
            for (std::size_t k = 1; k < 4; ++k)
                if (tiles[k].next < tiles[i].next) i = k;
            Tile& tile = tiles[i];
            while (!wire.empty() && wire.front().first <= tile.next) level = wire.front().second, wire.pop_front();
            const double now = tile.next;
            tile.clock(level);
            if (i == 0) {
                begun += tile.place == 0 ? 1 : 0;
                const bool high = tile.bench->o_sync != 0;
                if (high != sent) wire.emplace_back(now + 0.2 + (high ? 0.0 : std::exchange(widen, 0.0)), high);
                sent = high;
            } else if (tile.place == period / 2 && std::abs(tiles[0].place - period / 2) < period / 4) {
                ++compared;
                wrong += tile.bench->o_number != tiles[0].bench->o_number ? 1 : 0;
                unnumbered += tile.bench->o_agreed != 0 && tile.bench->o_in_step != 0 ? 0 : 1;
            }
        }
    }
    void forget() { compared = wrong = unnumbered = 0; }
};

// To be in step takes period / 8 cycles of seeking and 512 of learning; a number, two messages of 64 and the rest of
// one.
constexpr int until_in_step = period / 8 + 100 + 512, until_numbered = 200;

}  // namespace

TEST_CASE("carrier_sync, sync_number: slaves get the master's number, whatever it is") {
    Boards boards;
    const std::uint64_t first = (std::uint64_t{boards.tiles[0].bench.random()} & 0xffff'ffff'ffffU) | std::uint64_t{1}
                                                                                                          << 47;
    boards.set_master(first);
    boards.run(until_in_step + until_numbered);
    boards.forget();
    boards.run(400);
    CHECK(boards.compared >= 3 * 398);
    CHECK(boards.wrong == 0);
    CHECK(boards.unnumbered == 0);
    // Over the end of what 48 bits hold, and to another number altogether.
    boards.set_master(0xffff'ffff'ff80U);
    boards.run(3 * 64 + until_numbered);
    boards.forget();
    boards.run(200);
    CHECK(boards.tiles[0].bench->o_number < 1000);
    CHECK(boards.wrong == 0);
    CHECK(boards.unnumbered == 0);
}

TEST_CASE("carrier_sync, sync_number: a message that was heard wrongly changes no number") {
    Boards boards;
    boards.run(until_in_step + until_numbered);
    boards.forget();
    for (int i = 0; i < 12; ++i) {
        // Two bits of one message: a pulse that is 8 clocks longer is a 1 or a mark, or says nothing.
        for (int flips = 0; flips < 2; ++flips) {
            boards.widen = 8.0;
            boards.run(1 + static_cast<int>(boards.tiles[0].bench.number(0, 20)));
        }
        boards.run(2 * 64);
    }
    CHECK(boards.compared > 4000);
    CHECK(boards.wrong == 0);
    CHECK(boards.unnumbered < boards.compared);
    boards.run(128);
    boards.forget();
    boards.run(100);
    CHECK(boards.unnumbered == 0);
}
