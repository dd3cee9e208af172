// SPDX-License-Identifier: Apache-2.0
// How far apart the cycles of tiles begin that follow one master, with crystals that are as different as they may be
// and wander. Without what plays, so a million cycles take minutes; tests/tiles has whole boards.
#include <fmt/core.h>

#include <cstdlib>
#include <random>

#include "../soak.hpp"
#include "sync_boards.hpp"

using namespace sync_boards;

namespace {

/// Crystals of up to 50 ppm: the master at one end, slaves at both, and each wanders by up to 5 ppm.
struct Crystals {
    static constexpr double most_ppm = 50.0, wander_ppm = 5.0;
    std::vector<double> middle, now;
    std::mt19937 random;

    Crystals(std::size_t count, std::uint32_t seed) : random(seed) {
        std::uniform_real_distribution<double> share(-1.0, 1.0);
        const double end = share(random) < 0.0 ? wander_ppm - most_ppm : most_ppm - wander_ppm;
        for (std::size_t i = 0; i < count; ++i) middle.push_back(share(random) * (most_ppm - wander_ppm));
        middle[0] = middle[2] = end, middle[1] = -end;
        now = middle;
    }
    /// Each goes a small step, and stays where it may be.
    void wander(Boards& boards) {
        std::normal_distribution<double> step(0.0, 0.1);
        for (std::size_t i = 0; i < now.size(); ++i) {
            now[i] = std::clamp(now[i] + step(random), middle[i] - wander_ppm, middle[i] + wander_ppm);
            boards.tiles[i].set_ppm(now[i]);
        }
    }
};

}  // namespace

TEST_CASE("carrier_sync: cycles of four and nine tiles begin within two clocks of each other") {
    const std::size_t count = GENERATE(4, 9);
    const std::uint64_t cycles = haptogram::test::soaked(1'000'000, 1'000), until_wander = 20;  // half a millisecond
    Boards boards(count);
    Crystals crystals(count, static_cast<std::uint32_t>(Catch::rngSeed()));
    crystals.wander(boards);
    boards.run(until_in_step, [](std::size_t, double, bool) {});

    double worst = 0.0;
    std::uint64_t compared = 0, out_of_step = 0;
    int shortest = 2 * period, longest = 0;
    std::vector<std::uint64_t> begun(count, 0);
    std::vector<bool> whole(count, false);  // its cycle began after this was told to look
    for (std::uint64_t done = 0; done < cycles; done += until_wander) {
        crystals.wander(boards);
        boards.run(until_wander, [&](std::size_t i, double now, bool begins) {
            Tile& tile = boards.tiles[i];
            ++tile.length;
            if (!begins) return;
            // The later of two tiles sees how long ago the other's cycle began.
            for (std::size_t k = 0; k < count; ++k) {
                const double ago = now - boards.tiles[k].begun;
                if (k == i || ago > 0.5 * period) continue;
                ++compared;
                worst = std::max(worst, ago);
            }
            if (whole[i]) {
                shortest = std::min(shortest, tile.length), longest = std::max(longest, tile.length);
                ++begun[i];
            }
            whole[i] = true;
            tile.begun = now;
            tile.length = 0;
            if (i != 0 && !tile.bench->o_in_step) ++out_of_step;
        });
    }
    fmt::print("carrier_sync: seed {}, {} tiles, {} cycles: begun at most {:.3f} clocks apart, {} to {} clocks long\n",
               Catch::rngSeed(), count, cycles, worst, shortest, longest);
    CHECK(worst <= 2.0);
    CHECK(out_of_step == 0);
    // Nobody has lost a cycle or had one more.
    for (const std::uint64_t n : begun) CHECK(n + 2 >= cycles);
    for (const std::uint64_t n : begun) CHECK(n <= cycles + 1);
    CHECK(compared + 2 * count * count >= cycles * count * (count - 1) / 2);
    // No cycle is cut; what the master's are longer than the period is in docs/tiles.md.
    CHECK(shortest >= period);
    CHECK(longest <= period + 2);
}
