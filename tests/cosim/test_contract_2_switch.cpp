// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"
#include "haptogram/format/schedule.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

/// Plays two records in turn, one cycle each, on the board with 100 channels.
struct Alternation {
    std::uint16_t underruns;
    std::vector<sim::Dwell> dwells;
    sim::PulseReport report;
};

Alternation alternate(std::uint32_t cycle_clocks, std::uint16_t loops, std::uint8_t pulse) {
    auto g = generator();
    Bench bench("tile-100");
    const Image image =
        image_of(100, {random_record(g, 100, cycle_clocks, 1, pulse), random_record(g, 100, cycle_clocks, 1, pulse)});
    bench.load(image);
    bench.open();
    bench.client.start(1, 2, loops);
    bench.wait_for_index(2);
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 0; }, 2'000'000));
    bench.board.run(5000);
    return {bench.client.status().underruns, bench.recorder.dwells(), bench.check(image)};
}

}  // namespace

TEST_CASE("contract 2: the focus changes every carrier period with zero dead time", "[contract2][tile100]") {
    const Alternation result = alternate(1250, 100, 250);
    REQUIRE(result.underruns == 0);
    std::size_t changes = 0;
    for (std::size_t i = 1; i < result.dwells.size(); ++i) {
        if (result.dwells[i].index == 0) break;
        REQUIRE(result.dwells[i].begin == result.dwells[i - 1].end);
        REQUIRE(result.dwells[i].cycles == 1);
        REQUIRE(result.dwells[i].end - result.dwells[i].begin == 1250);
        ++changes;
    }
    REQUIRE(changes == 200);
    require_equal(result.report, 100 * 190);
}

TEST_CASE("contract 2: a record of 100 channels is loaded within the paper's 108 clocks", "[contract2][tile100]") {
    // Nothing inside is looked at: with a cycle of N clocks a new record every cycle is only possible when a record
    // loads in N.
    // The records have no pulses, because pulses from before the change have to end first.
    const std::uint32_t load = load_clocks(find_configuration("tile-100").parameters);
    REQUIRE(load == 107);
    REQUIRE(alternate(108, 50, 0).underruns == 0);
    REQUIRE(alternate(load + 1, 50, 0).underruns == 0);
    REQUIRE(alternate(load - 6, 50, 0).underruns > 0);
}

TEST_CASE("contract 2: loading begins when the last pulse from before the change has ended", "[contract2][tile100]") {
    // The shadow registers tell such pulses their end. At half the carrier period there is time left for 500 channels.
    // The rule: (pulse - 1) · prescaler + CHANNELS + 8 <= cycle, in clocks; 213 clocks at half of the cycle.
    REQUIRE(alternate(1250, 50, 255).underruns == 0);
    REQUIRE(alternate(213, 50, 106).underruns == 0);
    const Alternation late = alternate(212, 50, 106);
    REQUIRE(late.underruns > 0);
    require_equal(late.report, 1000);
}

TEST_CASE("contract 2: a record that is not ready leaves the present one playing and counts an underrun",
          "[contract2][tile100]") {
    const Alternation result = alternate(60, 30, 12);
    REQUIRE(result.underruns >= 50);
    std::size_t late = 0;
    for (std::size_t i = 0; i + 1 < result.dwells.size(); ++i) {
        if (result.dwells[i].index == 0 || result.dwells[i + 1].index == 0) continue;  // silence needs no loading
        REQUIRE(result.dwells[i].cycles == 2);  // one that was wanted and one that waited
        ++late;
    }
    REQUIRE(late == result.underruns);
    require_equal(result.report, 1000);
}

TEST_CASE("contract 2: all channels change on one clock edge", "[contract2]") {
    Bench bench;
    const Image image = image_of(16, {record(16, 500, 1, 100, 5), record(16, 500, 1, 100, 333)});
    bench.load(image);
    bench.open();
    bench.client.start(1, 2, 0);
    bench.wait_for_index(2);
    bench.board.run(50'000);
    for (const sim::CycleStart& start : bench.recorder.cycles()) {
        if (start.index == 0 || start.clock + 1000 > bench.board.now()) continue;
        const std::uint64_t expected = start.clock + (start.index == 1 ? 5U : 333U);
        for (std::uint32_t k = 0; k < 16; ++k) {
            const auto pulses = bench.pulses(k, start.clock, start.clock + 500);
            REQUIRE(pulses.size() == 1);
            REQUIRE(pulses[0].rise == expected);
        }
    }
}

TEST_CASE("contract 2: 40 kHz at half of the cycle, a new focus with other phases in every period",
          "[contract2][tile100]") {
    auto g = generator();
    Bench bench("tile-100");
    std::vector<Record> records;
    for (int i = 0; i < 20; ++i) records.push_back(random_record(g, 100, 250, 5, 125));
    const Image image = image_of(100, records);
    bench.load(image);
    bench.open();
    bench.client.start(1, 20, 10);
    bench.wait_for_index(20);
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 0; }, 2'000'000));
    bench.board.run(5000);
    const link::Status status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
    REQUIRE(status.guard_trips == 0);
    require_equal(bench.check(image), 100 * 100);  // pulses that merge count as one
}
