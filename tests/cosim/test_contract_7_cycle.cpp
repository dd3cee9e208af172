// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

TEST_CASE("contract 7: a record plays once, a number of times, or repeats", "[contract7]") {
    Bench bench;
    const Image image = image_of(16, {record(16, 200, 1, 50, 20)});
    bench.load(image);
    bench.open();
    const std::uint16_t dwell = GENERATE(std::uint16_t{1}, std::uint16_t{7}, std::uint16_t{300});
    bench.client.select(1, dwell);
    bench.board.run(80'000);
    REQUIRE(bench.board.outputs().index == 0);
    std::size_t times = 0;
    for (const Pulse& p : bench.recorder.pulses()) times += p.channel == 0 ? 1 : 0;
    REQUIRE(times == dwell);
    bench.client.select(1);
    const std::size_t before = bench.recorder.pulses().size();
    bench.board.run(400'000);
    REQUIRE(bench.board.outputs().index == 1);
    REQUIRE(bench.recorder.pulses().size() > before + 16 * 1990);
}

TEST_CASE("contract 7: the longest dwell is counted in full", "[contract7][long]") {
    Bench bench;
    const Image image = image_of(16, {record(16, 24, 1, 2, 3)});
    bench.load(image);
    bench.open();
    bench.client.select(1, 65535);
    bench.wait_for_index(1);
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 0; }, 2'000'000));
    std::uint32_t cycles = 0;
    for (const sim::Dwell& d : bench.recorder.dwells())
        if (d.index == 1) cycles = d.cycles;
    REQUIRE(cycles == 65535);
}

TEST_CASE("contract 7: counter and prescaler are 24 bits wide", "[contract7][long]") {
    const auto [cycle, prescaler] = GENERATE(table<std::uint32_t, std::uint32_t>({
        {0x12345, 1},  // more than 16 bits of cycle
        {3, 0x10007},  // more than 16 bits of prescaler
        {0x101, 0x301},
    }));
    CAPTURE(cycle, prescaler);
    // Pulses of one tick; with a large prescaler the guard would end them, so those are silent and timed by the cycle
    // starts.
    const std::uint8_t pulse = prescaler > 0x1000 ? 0 : 1;
    Bench bench;
    const Image image = image_of(16, {record(16, cycle, prescaler, pulse, 2)});
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.wait_for_index(1);
    const std::size_t begin = bench.recorder.cycles().size();
    REQUIRE(bench.board.run_until([&] { return bench.recorder.cycles().size() >= begin + 3; }, 2'000'000));
    const auto& cycles = bench.recorder.cycles();
    for (std::size_t i = begin; i + 1 < cycles.size(); ++i)
        REQUIRE(cycles[i + 1].clock - cycles[i].clock == std::uint64_t{cycle} * prescaler);
}

TEST_CASE("contract 7: all 24 bits of the cycle length count", "[contract7][long]") {
    Bench bench;
    const Image image = image_of(16, {record(16, 0x800001, 1, 1, 2)});
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.wait_for_index(1);
    const std::size_t begin = bench.recorder.cycles().size();
    REQUIRE(bench.board.run_until([&] { return bench.recorder.cycles().size() > begin; }, 9'000'000));
    REQUIRE(bench.recorder.cycles().back().clock - bench.recorder.cycles()[begin - 1].clock == 0x800001);
}
