// SPDX-License-Identifier: Apache-2.0
#include "../refusal.hpp"
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

Image twelve_records() {
    std::vector<Record> records;
    for (std::uint16_t i = 0; i < 12; ++i) records.push_back(record(16, 100, 1, 20, static_cast<std::uint16_t>(5 * i)));
    return image_of(16, records);
}

/// (index, cycles) as measured at the pins, silence before and after left out.
std::vector<std::pair<int, int>> played(const Bench& bench) {
    std::vector<std::pair<int, int>> result;
    for (const sim::Dwell& dwell : bench.recorder.dwells())
        result.emplace_back(dwell.index, static_cast<int>(dwell.cycles));
    while (!result.empty() && result.front().first == 0) result.erase(result.begin());
    while (!result.empty() && result.back().first == 0) result.pop_back();
    return result;
}

using Steps = std::vector<std::pair<int, int>>;

}  // namespace

TEST_CASE("contract 6: a sequence plays its entries for their dwells, as often as asked", "[contract6]") {
    Bench bench;
    Image image = twelve_records();
    image.sequence = {{3, 2}, {12, 1}, {0, 3}, {1, 5}};
    bench.load(image);
    bench.open();
    SECTION("once") {
        bench.client.start(1, 4, 1);
        bench.board.run(10'000);
        REQUIRE(played(bench) == Steps{{3, 2}, {12, 1}, {0, 3}, {1, 5}});
    }
    SECTION("three times") {
        bench.client.start(1, 4, 3);
        bench.board.run(10'000);
        REQUIRE(
            played(bench) ==
            Steps{{3, 2}, {12, 1}, {0, 3}, {1, 5}, {3, 2}, {12, 1}, {0, 3}, {1, 5}, {3, 2}, {12, 1}, {0, 3}, {1, 5}});
    }
    SECTION("a part of it") {
        bench.client.start(2, 2, 2);
        bench.board.run(10'000);
        REQUIRE(played(bench) == Steps{{12, 1}, {0, 3}, {12, 1}});
    }
    SECTION("for ever, until stopped") {
        bench.client.start(1, 4, 0);
        bench.board.run(200'000);
        REQUIRE(played(bench).size() > 600);
        bench.client.stop();
        bench.board.run(500);
        const std::size_t pulses = bench.recorder.pulses().size();
        REQUIRE(bench.board.outputs().index == 0);
        bench.board.run(100'000);
        REQUIRE(bench.recorder.pulses().size() == pulses);
    }
    require_equal(bench.check(image), 30);
}

TEST_CASE("contract 6: a host that hears nothing and is told idle, or an empty FIFO, has heard all", "[contract6]") {
    Bench bench;
    Image image = twelve_records();
    image.sequence = {{3, 2}, {0, 600}, {1, 5}};
    bench.load(image);
    bench.open();
    const bool live = GENERATE(false, true);
    SECTION(live ? "live" : "a sequence") {
        if (live) {
            bench.client.push({0}, 3000);  // until all are there
            bench.client.push({3}, 2);
            bench.client.push({0}, 600);
            bench.client.push({1}, 5);
            bench.client.push({0}, 0);
        } else {
            bench.client.start(1, 3, 1);
        }
        bool silent = false;
        link::Status status = bench.client.status();
        for (; !link::is_over(status); status = bench.client.status())
            silent = silent || (status.present_index == 0 && bench.recorder.pulses().size() >= 32);
        REQUIRE(silent);
        REQUIRE(bench.recorder.pulses().size() == 7 * 16);
        REQUIRE(played(bench) == Steps{{3, 2}, {0, 600}, {1, 5}});
    }
    SECTION("one index") {
        bench.client.select(7, 900);
        REQUIRE(bench.client.status().mode == link::Mode::idle);  // it plays, and nothing is to come
        link::Status status = bench.client.status();
        REQUIRE(status.present_index == 7);
        while (!link::is_over(status)) status = bench.client.status();
        REQUIRE(bench.recorder.pulses().size() == 900 * 16);
    }
}

TEST_CASE("contract 6: length 0 takes length and loops from the sequence header", "[contract6]") {
    Bench bench;
    Image image = twelve_records();
    image.sequence = {{2, 1}, {4, 2}};
    image.loops = 2;
    bench.load(image);
    bench.open();
    bench.client.start(0, 0, 0);
    bench.board.run(20'000);
    REQUIRE(played(bench) == Steps{{2, 1}, {4, 2}, {2, 1}, {4, 2}});
    SECTION("a header that describes nothing playable is refused, and what plays goes on") {
        const std::uint16_t header = GENERATE(std::uint16_t{0}, std::uint16_t{64}, std::uint16_t{0xffff});
        bench.client.select(1);
        bench.wait_for_index(1);
        bench.client.write(interface::sequence_base, words({header, 0}));
        REQUIRE_REFUSED(bench.client.start(0, 0, 0));
        bench.board.run(5000);
        REQUIRE(bench.board.outputs().index == 1);
    }
}

TEST_CASE("contract 6: index 0 is silence, indices run from 1 to the last record", "[contract6]") {
    Bench bench;
    std::vector<Record> records;
    for (std::uint16_t i = 0; i < 40; ++i) records.push_back(record(16, 100, 1, 20, i));
    const Image image = image_of(16, records);
    bench.load(image);
    bench.open();
    bench.client.select(1);
    bench.board.run(1000);
    REQUIRE(bench.board.outputs().index == 1);
    bench.client.select(40);
    bench.board.run(1000);
    REQUIRE(bench.board.outputs().index == 40);
    bench.client.select(0);
    bench.board.run(1000);
    const std::size_t pulses = bench.recorder.pulses().size();
    bench.board.run(10'000);
    REQUIRE(bench.board.outputs().index == 0);
    REQUIRE(bench.recorder.pulses().size() == pulses);
    require_equal(bench.check(image), 100);
}

TEST_CASE("contract 6: an index in memory above RECORDS is refused and silent for its dwell", "[contract6]") {
    Bench bench;
    Image image = twelve_records();
    image.sequence = {{1, 1}, {41, 4}, {32767, 1}, {2, 1}};
    bench.load(image);
    bench.open();
    bench.client.start(1, 4, 1);
    bench.board.run(3000);
    REQUIRE(played(bench) == Steps{{1, 1}, {41, 4}, {32767, 1}, {2, 1}});
    for (const Pulse& p : bench.recorder.pulses()) REQUIRE(p.index <= 2);
    REQUIRE(bench.client.status().refused_records == 2);
}

TEST_CASE("contract 6: live indices play in order, their level is in every acknowledgement", "[contract6][live]") {
    Bench bench;
    const Image image = twelve_records();
    bench.load(image);
    bench.open();
    bench.client.push({5, 6, 7, 8}, 40);  // 4,000 clocks each, longer than a reply takes
    bench.client.push({9, 10}, 3);
    const link::Status status = bench.client.status();
    REQUIRE(status.mode == link::Mode::live);
    REQUIRE(status.live_level > 0);
    REQUIRE(status.live_level < 6);
    bench.board.run(60'000);
    auto steps = played(bench);
    REQUIRE(steps.size() == 6);
    REQUIRE(Steps(steps.begin(), steps.end() - 1) == Steps{{5, 40}, {6, 40}, {7, 40}, {8, 40}, {9, 3}});
    REQUIRE(steps.back().first == 10);  // held, since nothing follows, and that is an underrun
    REQUIRE(bench.client.status().underruns == 1);
    bench.client.push({1}, 0);
    bench.wait_for_index(1);
    bench.board.run(20'000);
    REQUIRE(bench.board.outputs().index == 1);  // dwell 0 waits for the next without complaint
    REQUIRE(bench.client.status().underruns == 1);
    require_equal(bench.check(image), 1000);
}

TEST_CASE("contract 6: a push that does not fit, or has a bad index, pushes nothing", "[contract6][live]") {
    Bench bench;  // 16 places
    const Image image = twelve_records();
    bench.load(image);
    bench.open();
    bench.client.push({1, 2, 3}, 2000);
    const auto level = bench.client.status().live_level;
    REQUIRE_REFUSED(bench.client.push({4, 5, 41}, 1));
    REQUIRE(bench.client.status().live_level == level);
    std::vector<std::uint16_t> many(static_cast<std::size_t>(16 - level + 1), 6);
    REQUIRE_REFUSED(bench.client.push(many, 1));
    REQUIRE(bench.client.status().live_level == level);
    many.pop_back();
    bench.client.push(many, 1);
    REQUIRE(bench.client.status().live_level == 16);
    bench.client.stop();
    REQUIRE(bench.client.status().live_level == 0);
}

TEST_CASE("modes: each command takes over from any other at the next cycle boundary", "[modes]") {
    Bench bench;
    Image image = twelve_records();
    image.sequence = {{1, 1}, {2, 1}};
    bench.load(image);
    bench.open();
    auto g = generator();
    for (int i = 0; i < 60; ++i) {
        bench.board.run(random(g, 0, 300));
        const bool forever = random(g, 0, 1) == 0;
        switch (random(g, 0, 3)) {
            case 0:
                bench.client.select(7, static_cast<std::uint16_t>(forever ? 0 : 1000));
                REQUIRE((bench.board.run(250), bench.board.outputs().index) == 7);
                REQUIRE(bench.client.status().mode ==
                        (forever ? link::Mode::single : link::Mode::idle));  // the silence after it is already waiting
                break;
            case 1:
                bench.client.start(1, 2, 0);
                REQUIRE((bench.board.run(250), bench.board.outputs().index) <= 2);
                REQUIRE(bench.board.outputs().index >= 1);
                REQUIRE(bench.client.status().mode == link::Mode::sequence);
                break;
            case 2:
                bench.client.push({9}, 0);
                REQUIRE((bench.board.run(250), bench.board.outputs().index) == 9);
                REQUIRE(bench.client.status().mode == link::Mode::live);
                break;
            default:
                bench.client.stop();
                REQUIRE((bench.board.run(250), bench.board.outputs().index) == 0);
                REQUIRE(bench.client.status().mode == link::Mode::idle);
        }
    }
    require_equal(bench.check(image), 1000);
}
