// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

link::Bytes record_bytes(const Record& r) {
    return words(primary_words(image_of(static_cast<std::uint32_t>(r.timings.size()), {r})));
}

}  // namespace

TEST_CASE("contract 3: a record written while it plays is seen whole or not at all", "[contract3][long]") {
    // Both contents hold all channels at one tick, so that any mixture shows as channels that rise apart.
    constexpr int writes = 400;
    auto g = generator();
    Bench bench;
    // A cycle barely longer than a load: the memory is being read almost all the time.
    const Record a = record(16, 40, 1, 8, 4);
    const Record b = record(16, 40, 1, 8, 29);
    Image image = image_of(16, {a});
    image.sequence = {{1, 1}, {1, 1}};
    bench.load(image);
    bench.open();
    bench.client.start(1, 2, 0);  // both entries are record 1: it is read again in every cycle
    bench.wait_for_index(1);
    for (int i = 0; i < writes; ++i) {
        bench.board.run(random(g, 0, 97));
        bench.client.write(interface::primary_base, record_bytes(i % 2 == 0 ? b : a));
    }
    std::size_t seen_a = 0;
    std::size_t seen_b = 0;
    std::size_t changes = 0;
    std::uint64_t last_tick = 4;
    const auto& pulses = bench.recorder.pulses();
    const auto& cycles = bench.recorder.cycles();
    // A pulse falls before the next cycle's rises, so 16 pulses in a row belong to one cycle.
    for (std::size_t i = 0, c = 0; i + 16 <= pulses.size(); i += 16) {
        for (std::size_t k = 1; k < 16; ++k) REQUIRE(pulses[i + k].rise == pulses[i].rise);
        while (c + 1 < cycles.size() && cycles[c + 1].clock <= pulses[i].rise) ++c;
        const std::uint64_t tick = pulses[i].rise - cycles[c].clock;
        REQUIRE((tick == 4 || tick == 29));
        ++(tick == 4 ? seen_a : seen_b);
        if (tick != last_tick) ++changes;
        last_tick = tick;
    }
    REQUIRE(seen_a > 1000);
    REQUIRE(seen_b > 1000);
    REQUIRE(changes >= writes - 2);  // every write was seen
}

TEST_CASE("contract 3: a sequence entry written while it plays is old or new", "[contract3]") {
    auto g = generator();
    Bench bench;
    const Image image = image_of(16, {record(16, 60, 1, 8, 4), record(16, 60, 1, 8, 30)});
    bench.load(image);
    bench.open();
    bench.client.start(1, 1, 0);
    bench.wait_for_index(1);
    const std::size_t begin = bench.recorder.cycles().size();
    for (int i = 0; i < 200; ++i) {
        bench.board.run(random(g, 0, 97));
        const std::uint8_t which = i % 2 == 0 ? 2 : 1;  // index 2 for 2 cycles, index 1 for 1
        bench.client.write(interface::sequence_base + 4, {which, 0, which, 0});
    }
    std::size_t twos = 0;
    const auto dwells = bench.recorder.dwells();
    for (std::size_t i = 1; i + 1 < dwells.size(); ++i) {
        if (dwells[i].begin < bench.recorder.cycles()[begin].clock) continue;
        REQUIRE((dwells[i].index == 1 || dwells[i].index == 2));
        if (dwells[i].index == 2) {
            REQUIRE(dwells[i].cycles % 2 == 0);
            ++twos;
        }
    }
    REQUIRE(twos >= 95);
}
