// SPDX-License-Identifier: Apache-2.0
// The whole way of an image at the parameters that the board itself has: for the RTL, and for netlists as they are
// placed.
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

TEST_CASE("an image of 20 points, uploaded over the line, plays as it was compiled", "[whole]") {
    constexpr std::uint16_t points = 20;
    auto g = generator();
    Bench bench("tile-100");
    const auto& p = bench.board.parameters();
    const std::uint32_t cycle = p.clock_hz / 5 / 40'000;  // ticks of five clocks: 40 kHz
    REQUIRE(cycle < (1U << p.timing_bits));
    std::vector<Record> records;
    for (std::uint16_t i = 0; i < points; ++i)
        records.push_back(random_record(g, p.channels, cycle, 5, static_cast<std::uint8_t>(cycle / 2)));
    const Image image = image_of(p.channels, std::move(records));
    bench.client.identify();
    link::upload(bench.client, image);
    bench.client.set_watchdog(0);
    bench.client.enable();
    bench.client.start(1, points, 2);
    bench.wait_for_index(1);
    REQUIRE(bench.board.run_until([&] { return bench.board.outputs().index == 0; }, 200'000));
    bench.board.run(5000);
    std::vector<std::uint16_t> order;
    for (const sim::Dwell& dwell : bench.recorder.dwells())
        if (dwell.index != 0) order.push_back(dwell.index);
    REQUIRE(order.size() == 2 * points);
    for (std::size_t i = 0; i < order.size(); ++i) REQUIRE(order[i] == i % points + 1);
    require_equal(bench.check(image), points * p.channels);  // some merge at a change
    const auto status = bench.client.status();
    REQUIRE(status.underruns == 0);
    REQUIRE(status.refused_records == 0);
    REQUIRE(status.frames_damaged == 0);
}
