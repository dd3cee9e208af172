// SPDX-License-Identifier: Apache-2.0
// Reference boards on one wire, against Verilated ones and in step with each other. That a single one does what the
// core does is in ../reference.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "../refusal.hpp"
#include "bench.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/client.hpp"
#include "rig_simulation.hpp"
#include "tiles.hpp"

using namespace haptogram;

namespace {

constexpr double clock_fs = 2e7, period_clocks = 1250;

std::vector<sim::Oscillator> oscillators(std::mt19937& g, std::size_t count) {
    auto made = sim::random_oscillators(count, 50.0, static_cast<std::uint32_t>(g()));
    for (sim::Oscillator& oscillator : made) oscillator.wander_ppm = 0.0;  // so that a clock's time can be computed
    return made;
}

/// Boards, their hosts, and when their cycles begin.
struct Bench {
    std::unique_ptr<sim::Tiles> tiles;
    std::vector<sim::Oscillator> crystals;
    std::vector<std::unique_ptr<sim::TileTransport>> lines;
    std::vector<std::unique_ptr<link::Client>> hosts;
    std::vector<std::vector<std::uint64_t>> begins;

    Bench(std::unique_ptr<sim::Tiles> boards, std::vector<sim::Oscillator> of_boards)
        : tiles(std::move(boards)), crystals(std::move(of_boards)), begins(tiles->size()) {
        for (std::size_t i = 0; i < tiles->size(); ++i) {
            lines.push_back(std::make_unique<sim::TileTransport>(*tiles, i));
            hosts.push_back(std::make_unique<link::Client>(*lines.back()));
            tiles->board(i).on_cycle_start(
                [this, i](const sim::CycleStart& start) { begins[i].push_back(start.clock); });
            hosts.back()->identify();
        }
        for (std::size_t i = 0; i < hosts.size(); ++i)
            hosts[i]->set_role(i == 0 ? interface::Role::master : interface::Role::slave);
    }
    void run_ms(double milliseconds) {
        tiles->run(static_cast<sim::Femtoseconds>(milliseconds * 1000.0) * sim::microsecond);
    }
    [[nodiscard]] double time_fs(std::size_t board, std::uint64_t clock) const {
        const sim::Oscillator& crystal = crystals[board];
        return clock_fs * (crystal.phase + static_cast<double>(clock) / (1.0 + crystal.offset_ppm * 1e-6));
    }
    /// How far the last so many cycles of a slave begin from the nearest of the master, in clocks, at most.
    [[nodiscard]] double worst(std::size_t slave, std::size_t cycles) const {
        double worst = 0.0;
        for (auto clock = begins[slave].rbegin(); clock != begins[slave].rbegin() + static_cast<std::ptrdiff_t>(cycles);
             ++clock) {
            double nearest = std::numeric_limits<double>::infinity();
            const double at = time_fs(slave, *clock);
            for (const std::uint64_t begin : begins[0]) nearest = std::min(nearest, std::abs(time_fs(0, begin) - at));
            worst = std::max(worst, nearest / clock_fs);
        }
        return worst;
    }
};

/// Reference boards that play one record in step, and an instrument at their pins.
struct Playing {
    static constexpr std::uint32_t length = 250;
    test::TileBench bench;
    test::PinWatch watch;

    Playing(const std::vector<sim::Oscillator>& crystals, std::uint32_t seed)
        : bench(std::make_unique<sim::ReferenceTiles>("tile-100-sync", crystals, seed)),
          watch(bench.tiles, 4, static_cast<std::uint32_t>(period_clocks), length) {
        Image image;
        image.channels = 100;
        image.clock_hz = 50'000'000;
        image.records.push_back({1250, 1, length, std::vector<std::uint16_t>(100, interface::silent_timing)});
        // Every place in the cycle, its end and its beginning.
        const std::uint16_t timings[] = {0, 617, 1249, 1100};
        std::ranges::copy(timings, image.records[0].timings.begin());
        image.sequence.push_back({1, 0});
        bench.load(image);
        bench.join();
        bench.play(1);
        run_cycles(3);
        watch.begin();
    }
    /// The boards run one after the other, so in steps in which no pulse of one period meets one of the next.
    void run_cycles(std::size_t cycles) const {
        for (std::size_t step = 0; step < 5 * cycles; ++step) bench.tiles.run(5 * sim::microsecond);
    }
    [[nodiscard]] std::string found() const {
        return fmt::format("edges at most {:.3f} clocks apart; {} pulses, {} cut, {} lost, {} doubled",
                           watch.worst_clocks, watch.pulses, watch.cut, watch.lost, watch.doubled);
    }
    void judge(double most_clocks) const {
        CHECK(watch.worst_clocks <= most_clocks);
        CHECK(watch.cut + watch.lost + watch.doubled == 0);
        CHECK(watch.longest <= length + 2);
    }
};

}  // namespace

TEST_CASE("reference tiles: begin their cycles together, with the master's numbers, and say when SYNC is lost") {
    std::mt19937 g(Catch::rngSeed());
    const auto crystals = oscillators(g, 4);
    Bench bench(std::make_unique<sim::ReferenceTiles>("tile-100-sync", crystals, static_cast<std::uint32_t>(g())),
                crystals);
    bench.run_ms(25);
    for (std::size_t i = 1; i < 4; ++i) {
        const auto status = bench.hosts[i]->status();
        REQUIRE(status.in_step);
        REQUIRE(status.numbered);
        REQUIRE(status.sync_misses == 0);
        const double worst = bench.worst(i, 300);
        fmt::print(
            "tiles: seed {}, reference tile {} at {:+.0f} ppm begins its cycles within {:.2f} clocks of the master\n",
            Catch::rngSeed(), i + 1, crystals[i].offset_ppm, worst);
        REQUIRE(worst <= 2.0);
    }
    // Periods have one number everywhere: asked one after the other, none is behind.
    std::uint64_t before = 0;
    for (int round = 0; round < 3; ++round)
        for (auto& host : bench.hosts) {
            const std::uint64_t period = host->status().period.value();
            REQUIRE(period >= before);
            REQUIRE(period < before + (before == 0 ? 1'000'000 : 400));
            before = period;
        }
    for (auto& host : bench.hosts) host->enable();
    bench.tiles->connect(2, false);
    bench.run_ms(2);
    const auto lost = bench.hosts[2]->status();
    REQUIRE(lost.sync_losses == 1);
    REQUIRE_FALSE(lost.enabled);
    REQUIRE(bench.hosts[1]->status().enabled);
    REQUIRE(bench.hosts[3]->status().in_step);
}

TEST_CASE("reference tiles: their cycles begin at the clocks of Verilated ones") {
    std::mt19937 g(Catch::rngSeed() + 1);
    auto crystals = oscillators(g, 2);
    const auto seed = static_cast<std::uint32_t>(g());
    Bench reference(std::make_unique<sim::ReferenceTiles>("tile-100-sync", crystals, seed), crystals);
    Bench core(std::make_unique<sim::SimulatedTiles>("tile-100-sync", crystals, seed), crystals);
    for (Bench* bench : {&reference, &core}) bench->run_ms(18);
    for (std::size_t i = 0; i < 2; ++i) {
        const std::size_t cycles = std::min(reference.begins[i].size(), core.begins[i].size());
        REQUIRE(cycles > 600);
        // A clock that comes within 0.1 ns of an edge of the wire may see it or not.
        std::size_t other = 0;
        for (std::size_t k = 0; k < cycles; ++k) {
            const auto a = static_cast<double>(reference.begins[i][k]), b = static_cast<double>(core.begins[i][k]);
            REQUIRE(std::abs(a - b) <= 1.0);
            other += a != b ? 1 : 0;
        }
        REQUIRE(other <= cycles / 20);
        REQUIRE(static_cast<double>(core.begins[i][cycles - 1]) > 0.95 * period_clocks * static_cast<double>(cycles));
    }
}

TEST_CASE("reference tiles: pulses of whole boards stay together for a million cycles", "[deep]") {
    const bool one_clock = GENERATE(false, true);
    const std::size_t boards = GENERATE(4, 9);
    constexpr std::size_t cycles = 1'000'000;
    std::mt19937 g(Catch::rngSeed());
    std::vector<sim::Oscillator> crystals =
        one_clock ? test::crystals(boards, 0.0, 0.0, g) : test::crystals(boards, 50.0, 5.0, g);
    // SYNC may change in any part of the clock.
    const double delay_s = 20e-9 * std::uniform_real_distribution<double>(0.0, 1.0)(g);
    if (one_clock)
        for (sim::Oscillator& crystal : crystals) crystal.phase = 1.0, crystal.wire_delay_s += delay_s;
    Playing playing(crystals, static_cast<std::uint32_t>(g()));
    playing.run_cycles(cycles);
    const test::PinWatch& watch = playing.watch;
    fmt::print("tiles: seed {}, {} reference boards with {}, {} cycles: {}, {} longer, by at most {}\n",
               Catch::rngSeed(), boards, one_clock ? "one clock" : "crystals of their own", cycles, playing.found(),
               watch.stretched, watch.longest - playing.length);
    playing.judge(one_clock ? 1.0001 : 2.0);  // times are rounded
    CHECK(watch.pulses + 16 * boards >= 4 * boards * (cycles - cycles / 1000));
    for (std::size_t i = 0; i < boards; ++i) CHECK(playing.bench.host(i).status().sync_misses == 0);
}

TEST_CASE("reference tiles: SYNC is lost for less than 16 cycles, many times") {
    std::mt19937 g(Catch::rngSeed() + 2);
    Playing playing(test::crystals(4, 50.0, 5.0, g), static_cast<std::uint32_t>(g()));
    // A contact that opens or closes while the wire is high makes an edge of its own, which a slave takes for SYNC's
    // when it comes within 8 clocks of that; the contract says so.
    const auto wait_for_low = [&playing] {
        while (playing.bench.tiles.board(0).outputs().sync) playing.bench.tiles.run(sim::microsecond);
    };
    constexpr std::size_t losses = 1000;
    std::size_t missed = 0, counted = 0;
    for (std::size_t i = 0; i < losses; ++i) {
        const std::size_t cycles = 1 + g() % 15, board = 1 + g() % 3;
        wait_for_low();
        playing.bench.tiles.connect(board, false);
        playing.run_cycles(cycles);
        wait_for_low();
        playing.bench.tiles.connect(board, true);
        playing.run_cycles(1 + g() % 400);
        missed += cycles;
    }
    for (std::size_t i = 1; i < 4; ++i) {
        const link::Status status = playing.bench.host(i).status();
        counted += status.sync_misses;
        CHECK(status.in_step);
        CHECK(status.enabled);
        CHECK(status.sync_losses == 0);
    }
    fmt::print("tiles: seed {}, {} losses of 1 to 15 cycles: {}; {} of {} missed edges counted\n", Catch::rngSeed(),
               losses, playing.found(), counted, missed);
    playing.judge(2.0);
    CHECK(counted + losses >= missed);
    CHECK(counted <= missed + 2 * losses);
}

TEST_CASE("reference tiles: cannot be chained") {
    std::mt19937 g(1);
    sim::ReferenceTiles tiles("tile-100-sync", oscillators(g, 2), 1);
    REQUIRE_REFUSED(tiles.chain());
}
