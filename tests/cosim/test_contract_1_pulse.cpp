// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

/// Plays record 1 for a while and returns the pulses of each channel in `cycles` whole cycles.
std::vector<std::vector<Pulse>> steady_pulses(Bench& bench, std::size_t cycles) {
    bench.open();
    bench.client.select(1);
    bench.wait_for_index(1);
    const auto& starts = bench.recorder.cycles();
    const std::size_t begin = starts.size() + 2;
    REQUIRE(bench.board.run_until([&] { return starts.size() > begin + cycles + 2; }, 5'000'000));
    std::vector<std::vector<Pulse>> result;
    for (std::uint32_t k = 0; k < bench.channels(); ++k)
        result.push_back(bench.pulses(k, starts[begin].clock, starts[begin + cycles].clock));
    return result;
}

}  // namespace

TEST_CASE("contract 1: one pulse a cycle, at its tick, of exactly its length", "[contract1]") {
    const auto [cycle, prescaler, pulse] = GENERATE(table<std::uint32_t, std::uint32_t, std::uint8_t>({
        {250, 5, 125},   // 50 % at 40 kHz
        {250, 5, 1},     // one tick
        {250, 5, 249},   // all but one tick
        {1250, 1, 250},  // the finest timer
        {40, 3, 20},
        {2, 7, 1},  // the shortest cycle that can hold a pulse
    }));
    CAPTURE(cycle, prescaler, static_cast<int>(pulse));
    auto g = generator();
    Bench bench;
    Image image = image_of(16, {random_record(g, 16, cycle, prescaler, pulse)});
    image.records[0].timings[0] = 0;                                       // first tick, first channel
    image.records[0].timings[15] = static_cast<std::uint16_t>(cycle - 1);  // last tick, last channel: wraps around
    bench.load(image);
    const auto pulses = steady_pulses(bench, 10);
    for (std::uint32_t k = 0; k < 16; ++k) {
        CAPTURE(k, image.records[0].timings[k]);
        REQUIRE(pulses[k].size() == 10);
        for (std::size_t i = 0; i < 10; ++i) {
            REQUIRE(pulses[k][i].fall - pulses[k][i].rise == std::uint64_t{pulse} * prescaler);
            if (i > 0) REQUIRE(pulses[k][i].rise - pulses[k][i - 1].rise == std::uint64_t{cycle} * prescaler);
            REQUIRE(pulses[k][i].rise - pulses[0][i].rise == std::uint64_t{image.records[0].timings[k]} * prescaler);
        }
    }
    require_equal(bench.check(image), 160);
}

TEST_CASE("contract 1: a pulse length of 0 and timings beyond the cycle silence a channel", "[contract1]") {
    Bench bench;
    Image image = image_of(16, {record(16, 100, 2, 30, 10), record(16, 100, 2, 0, 10), record(16, 5000, 1, 30, 10)});
    image.records[0].timings[1] = 99;
    image.records[0].timings[2] = 100;     // the cycle length
    image.records[0].timings[3] = 0x1003;  // wider than the 12 bits of this board: must not alias to 3
    image.records[0].timings[4] = 0xffff;
    image.records[2].timings[5] = 0x0fff;  // all ones in 12 bits never fires, though the cycle is longer
    image.records[2].timings[6] = 0x0ffe;
    bench.load(image);
    bench.open();
    const auto count = [&](std::uint16_t index, std::uint32_t channel) {
        bench.client.select(index);
        bench.wait_for_index(index);
        const std::uint64_t begin = bench.board.now() + 11'000;
        bench.board.run(22'000);
        return bench.pulses(channel, begin, begin + 10'000).size();
    };
    REQUIRE(count(1, 0) == 50);
    REQUIRE(count(1, 1) == 50);
    for (const std::uint32_t silent : {2U, 3U, 4U}) REQUIRE(count(1, silent) == 0);
    REQUIRE(count(2, 0) == 0);
    REQUIRE(count(3, 0) == 2);
    REQUIRE(count(3, 5) == 0);
    REQUIRE(count(3, 6) == 2);
}

TEST_CASE("contract 1: no pulse is cut, lost or doubled when the focus changes every cycle", "[contract1]") {
    // The next record loads, in 33 clocks, once the pulses from before the change have ended. With pulses of up to 25
    // ticks even a cycle of 60 has room for that; with longer ones some records play twice, and their pulses are whole
    // all the same.
    const std::uint32_t longest = GENERATE(25U, 255U);
    auto g = generator();
    Bench bench;
    std::vector<Record> records;
    for (int i = 0; i < 40; ++i) {
        const std::uint32_t cycle = random(g, 60, 300);
        records.push_back(random_record(g, 16, cycle, random(g, 1, 4),
                                        static_cast<std::uint8_t>(random(g, 0, std::min(cycle / 2, longest)))));
    }
    const Image image = image_of(16, records);
    bench.load(image);
    bench.open();
    bench.client.start(1, 40, 8);
    bench.wait_for_index(40);
    REQUIRE(bench.board.run_until([&] { return bench.recorder.cycles().back().index == 0; }, 4'000'000));
    bench.board.run(3000);
    if (longest == 25) REQUIRE(bench.client.status().underruns == 0);
    require_equal(bench.check(image), 2000);
}

TEST_CASE("contract 1: a pulse under way completes when playing stops", "[contract1]") {
    Bench bench;
    const Image image = image_of(16, {record(16, 200, 5, 150, 100)});  // from tick 100 to tick 50 of the next cycle
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.wait_for_index(1);
    bench.board.run(5000);
    bench.client.stop();
    bench.wait_for_index(0);
    bench.board.run(3000);
    REQUIRE_FALSE(bench.board.any_pin());
    for (const Pulse& p : bench.recorder.pulses()) REQUIRE(p.fall - p.rise == 750);
    REQUIRE(bench.recorder.pulses().back().fall > bench.recorder.dwells().back().begin);
}

TEST_CASE("contract 1: the first pulses after enabling are whole", "[contract1]") {
    auto g = generator();
    Bench bench;
    const Image image = image_of(16, {random_record(g, 16, 250, 1, 125)});
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.wait_for_index(1);
    for (int i = 0; i < 20; ++i) {
        bench.client.disable();
        REQUIRE_FALSE(bench.board.any_pin());
        const std::size_t before = bench.recorder.pulses().size();
        bench.board.run(random(g, 0, 400));
        bench.client.enable();
        bench.board.run(2000);
        REQUIRE(bench.recorder.pulses().size() > before + 16);
        for (std::size_t p = before; p < before + 16; ++p)
            REQUIRE(bench.recorder.pulses()[p].fall - bench.recorder.pulses()[p].rise == 125);
    }
}

TEST_CASE("contract 1: a gap of one tick between pulses is filled, a longer one is not", "[contract1]") {
    // Channel k ends k ticks after the change of record, and begins again at its tick in the new one.
    const std::uint32_t prescaler = GENERATE(1U, 5U);
    CAPTURE(prescaler);
    Bench bench;
    Image image = image_of(16, {record(16, 200, prescaler, 50, 0), record(16, 200, prescaler, 50, 0)});
    for (std::uint16_t k = 0; k < 16; ++k) {
        image.records[0].timings[k] = static_cast<std::uint16_t>(150 + 3 * k);    // ends at tick 3 k of the next cycle
        image.records[1].timings[k] = static_cast<std::uint16_t>(3 * k + k % 4);  // a gap of 0 to 3 ticks
    }
    bench.load(image);
    bench.open();
    bench.client.start(1, 2, 1);
    bench.board.run(3000);
    for (std::uint32_t k = 0; k < 16; ++k) {
        CAPTURE(k);
        std::vector<std::uint64_t> lengths;
        for (const Pulse& p : bench.recorder.pulses())
            if (p.channel == k) lengths.push_back(p.fall - p.rise);
        const std::uint64_t pulse = 50ULL * prescaler;
        if (k % 4 <= 1)
            REQUIRE(lengths == std::vector{2 * pulse + k % 4 * prescaler});
        else
            REQUIRE(lengths == std::vector{pulse, pulse});
    }
    require_equal(bench.check(image), 16);
}
