// SPDX-License-Identifier: Apache-2.0
// Contract 11: boards on one wire are one array. Every edge is measured at the pins, in the time that all boards share.
// Every case prints what it measured. `make test` runs seconds of it, HAPTOGRAM_SOAK=1, as in `make soak`, a million
// cycles.
#include <fmt/format.h>

#include <cstdlib>

#include "../period_check.hpp"
#include "../refusal.hpp"
#include "../soak.hpp"
#include "bench.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

constexpr std::uint32_t channels = 16, cycle = 1250, length = 250;

template <class... Values>
void figures(fmt::format_string<Values...> format, Values&&... values) {
    fmt::print("tiles: seed {}, {}\n", Catch::rngSeed(), fmt::format(format, std::forward<Values>(values)...));
    std::fflush(stdout);
}

/// One record that shows every place in the cycle, its end and its beginning, on four channels; the others are silent,
/// which makes the simulation quick.
Image four_pulses() {
    Image image;
    image.channels = channels;
    image.clock_hz = 50'000'000;
    image.records.push_back(
        {cycle, 1, static_cast<std::uint8_t>(length), std::vector<std::uint16_t>(channels, 0xffff)});
    const std::uint16_t timings[] = {0, 617, 1249, 1100};
    std::ranges::copy(timings, image.records[0].timings.begin());
    image.sequence.push_back({1, 0});
    return image;
}

void judge(const PinWatch& watch, double most_clocks) {
    CHECK(watch.worst_clocks <= most_clocks);
    CHECK(watch.cut == 0);
    CHECK(watch.lost == 0);
    CHECK(watch.doubled == 0);
    CHECK(watch.longest <= length + 2);
}

/// Boards with these oscillators play for so many cycles.
void play_together(const std::vector<sim::Oscillator>& oscillators, std::size_t cycles, double most_clocks) {
    TileBench bench("small-16-sync", oscillators, Catch::rngSeed());
    PinWatch watch(bench.tiles, 4, cycle, length);
    bench.load(four_pulses());
    const double joined = bench.join();
    bench.play(1);
    watch.begin();
    bench.run_ms(static_cast<double>(cycles) * 0.025);
    figures(
        "{} boards, {} cycles: edges at most {:.3f} clocks apart; {} pulses, {} cut, {} lost, {} doubled, {} longer, "
        "by at most {}; in step and numbered after {:.1f} ms",
        oscillators.size(), cycles, watch.worst_clocks, watch.pulses, watch.cut, watch.lost, watch.doubled,
        watch.stretched, watch.longest - length, joined * 1e3);
    judge(watch, most_clocks);
    // The master's cycles are 1250 and 1251 of its own clocks in turn, and all boards play as many as it does.
    const double share = 1250.0 / 1250.5 * (1.0 + oscillators[0].offset_ppm * 1e-6);
    const double expected = 4.0 * static_cast<double>(oscillators.size() * cycles) * share;
    CHECK(static_cast<double>(watch.pulses) == Approx(expected)
                                                   .epsilon(oscillators[0].wander_ppm * 1e-6)
                                                   .margin(16.0 * static_cast<double>(oscillators.size())));
    for (std::size_t i = 0; i < oscillators.size(); ++i) CHECK(bench.host(i).status().sync_misses == 0);
}

}  // namespace

TEST_CASE("contract 11, together: crystals of their own, four boards") {
    std::mt19937 g(Catch::rngSeed());
    play_together(crystals(4, 50.0, 5.0, g), soaked(1'000'000, 4'000), 2.0);
}

TEST_CASE("contract 11, together: crystals of their own, nine boards") {
    std::mt19937 g(Catch::rngSeed());
    play_together(crystals(9, 50.0, 5.0, g), soaked(1'000'000, 1'000), 2.0);
}

TEST_CASE("contract 11, together: one clock for all boards, and SYNC at any part of it") {
    std::mt19937 g(Catch::rngSeed());
    std::vector<sim::Oscillator> shared = crystals(4, 0.0, 0.0, g);
    // SYNC may change in any part of that clock, also just when it is looked at: then one board sees it a clock later.
    const double delay = 20e-9 * std::uniform_real_distribution<double>(0.0, 1.0)(g);
    for (std::size_t i = 0; i < shared.size(); ++i) shared[i].phase = 1.0, shared[i].wire_delay_s += delay;
    play_together(shared, soaked(1'000'000, 4'000), 1.0);
}

TEST_CASE("contract 11, together: boards with amplitudes") {
    std::mt19937 g(Catch::rngSeed());
    TileBench bench("tile-100-wide", crystals(3, 50.0, 5.0, g), Catch::rngSeed());
    constexpr std::uint32_t playing = 8;  // of the 100 channels; the others are silent
    PinWatch watch(bench.tiles, 100, cycle, cycle / 2);
    // Pulses of half a cycle, whose words are made anew in every cycle, at random places of it.
    std::vector<std::uint16_t> words;
    for (std::uint32_t k = 0; k < 100; ++k)
        words.push_back(static_cast<std::uint16_t>((k < playing ? 0xff00U : 0U) | g() % 256));
    for (std::size_t i = 0; i < 3; ++i) bench.load(i, amplitude_record(cycle, words));
    bench.join();
    bench.play(1);
    bench.run_ms(0.1);
    watch.begin();
    const std::size_t cycles = soaked(20'000, 200);
    bench.run_ms(static_cast<double>(cycles) * 0.025);
    figures(
        "3 boards with amplitudes, {} cycles: edges at most {:.3f} clocks apart; {} pulses, {} cut, {} lost, {} "
        "doubled",
        cycles, watch.worst_clocks, watch.pulses, watch.cut, watch.lost, watch.doubled);
    CHECK(watch.worst_clocks <= 2.0);
    CHECK(watch.cut + watch.lost + watch.doubled == 0);
    CHECK(watch.pulses + 64 * playing >= 3 * playing * cycles);
    for (std::size_t i = 0; i < 3; ++i) CHECK(bench.host(i).status().underruns == 0);
}

TEST_CASE("contract 11, together: SYNC is lost for less than 16 cycles, and nothing happens") {
    std::mt19937 g(Catch::rngSeed());
    TileBench bench("small-16-sync", crystals(4, 50.0, 5.0, g), Catch::rngSeed());
    PinWatch watch(bench.tiles, 4, cycle, length);
    bench.load(four_pulses());
    bench.join();
    bench.play(1);
    watch.begin();
    const std::size_t losses = soaked(200, 12);
    std::size_t missed = 0;
    for (std::size_t i = 0; i < losses; ++i) {
        const std::size_t cycles = 1 + g() % 15;
        const std::size_t board = 1 + i % 3;
        // A contact that opens or closes while the wire is high makes an edge of its own.
        const auto wait_for_low = [&bench] {
            while (bench.tiles.board(0).outputs().sync) bench.tiles.run(microsecond);
        };
        wait_for_low();
        bench.tiles.connect(board, false);
        bench.run_ms(static_cast<double>(cycles) * 0.025);
        wait_for_low();
        bench.tiles.connect(board, true);
        bench.run_ms(8.0);
        missed += cycles;
    }
    std::size_t counted = 0;
    for (std::size_t i = 1; i < 4; ++i) {
        const link::Status status = bench.host(i).status();
        counted += status.sync_misses;
        CHECK(status.in_step);
        CHECK(status.numbered);
        CHECK(status.enabled);
        CHECK(status.sync_losses == 0);
    }
    figures(
        "{} losses of 1 to 15 cycles: edges at most {:.3f} clocks apart; {} pulses, {} cut, {} lost, {} doubled; {} of "
        "{} missed edges counted",
        losses, watch.worst_clocks, watch.pulses, watch.cut, watch.lost, watch.doubled, counted, missed);
    judge(watch, 2.0);
    CHECK(counted + losses >= missed);
    CHECK(counted <= missed + 2 * losses);
}

TEST_CASE("contract 11, together: SYNC is lost for good, the outputs go off, and the host sees why") {
    std::mt19937 g(Catch::rngSeed());
    TileBench bench("small-16-sync", crystals(3, 50.0, 5.0, g), Catch::rngSeed());
    PinWatch watch(bench.tiles, 4, cycle, length);
    bench.load(four_pulses());
    bench.join();
    bench.play(1);
    watch.begin();
    bench.run_ms(10.0);
    bench.tiles.connect(1, false);
    // In step as long as it plays: the first edges after the outputs went off are falls that are cut off with
    // everything.
    sim::Board& alone = bench.tiles.board(1);
    const std::uint64_t from = alone.now();
    while (alone.outputs().enabled) {
        const std::uint64_t before = watch.pulses;
        bench.tiles.run(microsecond / 50);
        if (!alone.outputs().enabled && watch.pulses != before) break;
        REQUIRE(alone.now() - from < 40 * cycle);
    }
    watch.leave_out(1, true);
    CHECK(alone.now() - from > 14 * cycle);
    CHECK(alone.outputs().fault);
    bench.tiles.run(microsecond / 10);
    CHECK_FALSE(alone.any_pin());
    const link::Status status = bench.host(1).status();
    CHECK_FALSE(status.enabled);
    CHECK_FALSE(status.in_step);
    CHECK(status.sync_losses == 1);
    CHECK(status.sync_misses == 16);
    REQUIRE_REFUSED(bench.host(1).enable());

    // It comes back, the boards play together again, and the others never noticed.
    bench.tiles.connect(1, true);
    bench.wait_for_number(1);
    bench.host(1).enable();
    bench.run_ms(0.1);
    CHECK_FALSE(alone.outputs().fault);
    watch.leave_out(1, false);
    bench.run_ms(10.0);
    figures("SYNC lost for good and back: edges at most {:.3f} clocks apart; {} pulses, {} cut, {} lost, {} doubled",
            watch.worst_clocks, watch.pulses, watch.cut, watch.lost, watch.doubled);
    // One pulse a channel may end with the outputs, as with every fault.
    CHECK(watch.cut <= 4);
    watch.cut = 0;
    judge(watch, 2.0);
}

TEST_CASE("contract 11, together: a function generator in the master's place") {
    std::mt19937 g(Catch::rngSeed());
    TileBench bench("small-16-sync", crystals(3, 50.0, 5.0, g), Catch::rngSeed());
    PinWatch watch(bench.tiles, 4, cycle, length);
    bench.load(four_pulses());
    for (std::size_t i = 0; i < 3; ++i) {
        bench.host(i).set_role(Role::slave);
        bench.host(i).set_watchdog(0);
    }
    // 39.99 kHz, which is slower than any of the boards would be; half of the period high, so that it says no number.
    Femtoseconds at = bench.tiles.now() + microsecond;
    const auto generate = [&](double milliseconds) {
        const auto period = static_cast<Femtoseconds>(1e15 / 39.99e3);
        for (const Femtoseconds end = at + static_cast<Femtoseconds>(milliseconds * 1e12); at < end; at += period) {
            bench.tiles.drive_wire(at, true);
            bench.tiles.drive_wire(at + period / 2, false);
        }
    };
    generate(60.0);
    bench.run_ms(25.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const link::Status status = bench.host(i).status();
        CHECK(status.in_step);
        CHECK_FALSE(status.numbered);
    }
    bench.play(1);
    watch.begin();
    bench.run_ms(10.0);
    figures(
        "function generator of 39.99 kHz: edges at most {:.3f} clocks apart; {} pulses, {} cut, {} lost, {} doubled",
        watch.worst_clocks, watch.pulses, watch.cut, watch.lost, watch.doubled);
    judge(watch, 2.0);
}

TEST_CASE("contract 11, together: glitches on the wire between the edges change nothing") {
    std::mt19937 g(Catch::rngSeed());
    TileBench bench("small-16-sync", crystals(3, 50.0, 5.0, g), Catch::rngSeed());
    PinWatch watch(bench.tiles, 4, cycle, length);
    bench.load(four_pulses());
    bench.join();
    bench.play(1);
    watch.begin();
    // While the master's own pulses are low: in the middle half of its cycle. Its edges come 48 clocks before its cycle
    // ends.
    std::uint64_t start = 0;
    bench.tiles.board(0).on_cycle_start([&start](const sim::CycleStart& c) { start = c.clock; });
    for (int i = 0; i < 100; ++i) {
        const std::uint64_t place = 200 + g() % 700;
        while (bench.tiles.board(0).now() - start != place) bench.tiles.run(microsecond / 100);
        const auto width = static_cast<Femtoseconds>(g() % 600) * (microsecond / 1000);
        bench.tiles.drive_wire(bench.tiles.now() + microsecond / 100, true);
        bench.tiles.drive_wire(bench.tiles.now() + microsecond / 100 + width, false);
        bench.run_ms(0.1);
    }
    figures("100 glitches: edges at most {:.3f} clocks apart; {} pulses, {} cut, {} lost, {} doubled",
            watch.worst_clocks, watch.pulses, watch.cut, watch.lost, watch.doubled);
    judge(watch, 2.0);
    for (std::size_t i = 1; i < 3; ++i) {
        CHECK(bench.host(i).status().sync_misses == 0);
        CHECK(bench.host(i).status().numbered);
    }
}

TEST_CASE("contract 11, together: what a board with a role refuses") {
    TileBench bench("small-16-sync", std::vector<sim::Oscillator>(1), Catch::rngSeed());
    Image image = four_pulses();
    image.records.push_back(image.records.front());
    image.records[1].cycle_length = 1200;
    image.records[1].timings.assign(channels, 0);
    image.records.push_back(image.records.front());
    image.records[2].cycle_length = 250;
    image.records[2].prescaler = 5;
    image.records[2].pulse_length = 50;
    image.records[2].timings.assign(channels, 0);
    bench.load(image);
    link::Client& host = bench.host(0);
    sim::Board& board = bench.tiles.board(0);

    CHECK_FALSE(host.status().role != Role::alone);
    REQUIRE_REFUSED(host.set_role(static_cast<Role>(3)));
    host.set_watchdog(0);
    host.enable();
    host.select(2);
    bench.run_ms(0.2);
    CHECK(board.outputs().index == 2);
    CHECK(host.status().refused_records == 0);

    // A role resets; then only records of the common cycle are played, with any prescaler.
    host.set_role(Role::master);
    CHECK_FALSE(board.outputs().enabled);
    CHECK(host.status().role == Role::master);
    host.set_watchdog(0);
    host.enable();
    host.select(2);
    bench.run_ms(0.2);
    CHECK(host.status().refused_records == 1);
    CHECK_FALSE(board.any_pin());
    host.select(3);
    bench.run_ms(0.2);
    CHECK(host.status().refused_records == 1);
    CHECK(board.outputs().index == 3);

    host.set_role(Role::slave);
    host.set_watchdog(0);
    REQUIRE_REFUSED(host.enable());
    host.reset();
    CHECK(host.status().role == Role::alone);
    host.enable();
    CHECK(host.status().enabled);
}
