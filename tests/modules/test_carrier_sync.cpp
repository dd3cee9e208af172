// SPDX-License-Identifier: Apache-2.0
// rtl/time/carrier_sync.v, sync_number.v and period_count.v of one master and three slaves with clocks of their own.
// What is compared are numbers of periods, each in the middle of a period of its board.
#include "sync_boards.hpp"

namespace {

using namespace sync_boards;

struct Numbers {
    Boards boards{4};
    std::uint64_t compared = 0, wrong = 0, unnumbered = 0;  // of the slaves

    void run(int cycles) {
        boards.run(static_cast<std::uint64_t>(cycles), [this](std::size_t i, double, bool) {
            const Tile &tile = boards.tiles[i], &master = boards.tiles[0];
            if (i == 0 || tile.place != period / 2 || std::abs(master.place - period / 2) >= period / 4) return;
            ++compared;
            wrong += tile.bench.model->o_number != master.bench.model->o_number ? 1 : 0;
            unnumbered += tile.bench.model->o_agreed != 0 && tile.bench.model->o_in_step != 0 ? 0 : 1;
        });
    }
    void forget() { compared = wrong = unnumbered = 0; }
};

}  // namespace

TEST_CASE("carrier_sync, sync_number: slaves get the master's number, whatever it is") {
    Numbers numbers;
    Boards& boards = numbers.boards;
    const std::uint64_t first = (std::uint64_t{boards.tiles[0].bench.random()} & 0xffff'ffff'ffffU) | std::uint64_t{1}
                                                                                                          << 47;
    boards.set_master(first);
    numbers.run(until_in_step + until_numbered);
    numbers.forget();
    numbers.run(400);
    CHECK(numbers.compared >= 3 * 398);
    CHECK(numbers.wrong == 0);
    CHECK(numbers.unnumbered == 0);
    // Over the end of what 48 bits hold, and to another number altogether.
    boards.set_master(0xffff'ffff'ff80U);
    numbers.run(3 * 64 + until_numbered);
    numbers.forget();
    numbers.run(200);
    CHECK(boards.tiles[0].bench->o_number < 1000);
    CHECK(numbers.wrong == 0);
    CHECK(numbers.unnumbered == 0);
}

TEST_CASE("carrier_sync: a slave that becomes the master does not drive SYNC for an edge that it has heard") {
    Tile tile;
    int driven = 0, first = 0;  // clocks before, and of the cycle when it first drives
    for (int after = 0; after < 40; ++after) {
        tile.reset(2, 0.0);
        tile.bench->i_set = 1;
        tile.bench->i_number = tile.bench.random() & 0xffff'ffff'ffffU;
        for (int i = 0; i < 2 * period; ++i) tile.clock(false);
        for (int i = 0; i < after; ++i) tile.clock(true);
        tile.bench->i_role = 1;
        tile.bench->rst = 1;
        tile.clock(true);
        tile.bench->rst = 0;
        tile.place = 0;
        for (first = 0; tile.bench->o_sync == 0 && first < period; ++first) tile.clock(true);
        driven += first < period - 64 ? 1 : 0;
        CHECK(first < period);
    }
    CHECK(driven == 0);
}

TEST_CASE("carrier_sync, sync_number: a message that was heard wrongly changes no number") {
    Numbers numbers;
    Boards& boards = numbers.boards;
    numbers.run(until_in_step + until_numbered);
    numbers.forget();
    for (int i = 0; i < 12; ++i) {
        // Two bits of one message: a pulse that is 8 clocks longer is a 1 or a mark, or says nothing.
        for (int flips = 0; flips < 2; ++flips) {
            boards.widen = 8.0;
            numbers.run(1 + static_cast<int>(boards.tiles[0].bench.number(0, 20)));
        }
        numbers.run(2 * 64);
    }
    CHECK(numbers.compared > 4000);
    CHECK(numbers.wrong == 0);
    CHECK(numbers.unnumbered < numbers.compared);
    numbers.run(128);
    numbers.forget();
    numbers.run(100);
    CHECK(numbers.unnumbered == 0);
}
