// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/solve/focal_law.hpp"

using namespace haptogram;

TEST_CASE("focal law: waves arrive together, by flight time and emission tick", "[focus]") {
    const Core core;
    // The check is what the law is for, not its formula: emission time + flight time must agree modulo the period.
    const Array array = find_array(GENERATE("tile-10x10", "hoshi-18x18"));
    const Timer timer = choose_timer(array, core);
    std::mt19937_64 g(Catch::rngSeed());
    std::uniform_real_distribution<double> lateral(-0.08, 0.08);
    std::uniform_real_distribution<double> height(0.03, 0.3);
    std::vector<Vec3> foci;
    for (int i = 0; i < 500; ++i) foci.push_back({lateral(g), lateral(g), height(g)});
    const auto ticks = focal_law(array, timer, foci);
    const std::size_t elements = array.elements.size();
    REQUIRE(ticks.size() == foci.size() * elements);
    double worst = 0.0;
    for (std::size_t f = 0; f < foci.size(); ++f) {
        double arrival = 0.0;
        for (const Element& e : array.elements)
            arrival = std::max(arrival, distance(e, foci[f]) / array.medium.speed_m_s / timer.tick_s());
        for (std::size_t m = 0; m < elements; ++m) {
            const std::uint16_t tick = ticks[f * elements + m];
            REQUIRE(tick < timer.cycle_ticks);
            const double late =
                tick + distance(array.elements[m], foci[f]) / array.medium.speed_m_s / timer.tick_s() - arrival;
            worst = std::max(worst, std::abs(std::remainder(late, timer.cycle_ticks)));
        }
    }
    REQUIRE(worst <= 0.51);  // rounded to the nearest tick, not floored
    REQUIRE(worst > 0.45);
}

TEST_CASE("focal law: symmetric foci give mirrored ticks, and the axis gives one ring one tick", "[focus]") {
    const Core core;
    const Array array = find_array("tile-10x10");
    const Timer timer = choose_timer(array, core);
    const std::vector<Vec3> foci = {{0.01, 0.02, 0.13}, {-0.01, 0.02, 0.13}, {0.0, 0.0, 0.13}};
    const auto ticks = focal_law(array, timer, foci);
    for (std::size_t r = 0; r < 10; ++r)
        for (std::size_t q = 0; q < 10; ++q) {
            REQUIRE(ticks[r * 10 + q] == ticks[100 + r * 10 + 9 - q]);
            REQUIRE(ticks[200 + r * 10 + q] == ticks[200 + q * 10 + r]);
        }
    for (const std::size_t corner : {0U, 9U, 90U, 99U})
        REQUIRE(ticks[200 + corner] == 0);  // the farthest elements go first
}

TEST_CASE("focal law: any number of elements and foci, also fewer than a vector", "[focus]") {
    const Core core;
    Array array = find_array("tile-10x10");
    const Timer timer = choose_timer(array, core);
    const std::vector<Vec3> foci = {{0.013, -0.02, 0.11}};
    const auto all = focal_law(array, timer, foci);
    const auto elements = array.elements;
    for (std::size_t count = 1; count <= 40; ++count) {
        array.elements.assign(elements.begin(), elements.begin() + static_cast<std::ptrdiff_t>(count));
        const auto some = focal_law(array, timer, foci);
        REQUIRE(some.size() == count);
        // Dropping elements shifts all delays alike.
        for (std::size_t m = 0; m < count; ++m)
            REQUIRE(std::abs(std::remainder(static_cast<double>(some[m] - some[0]) - (all[m] - all[0]), 250.0)) <= 1.0);
    }
    REQUIRE(focal_law(array, timer, {}).empty());
    REQUIRE_THROWS_AS(focal_law(array, timer, std::vector<Vec3>{{0, 0, std::nan("")}}), Error);
}

TEST_CASE("timer: the finest that carries the duty at the exact carrier", "[focus]") {
    Core core;
    Array array;
    array.elements = {Element{}};
    const auto [clock, duty, prescaler, cycle, pulse] = GENERATE(table<double, double, unsigned, unsigned, unsigned>({
        {50e6, 0.5, 5, 250, 125},
        {50e6, 0.2, 1, 1250, 250},
        {50e6, 0.25, 2, 625, 156},
        {48e6, 0.5, 3, 400, 200},
        {25e6, 0.5, 5, 125, 62},  // the board plays at most half of a cycle
        {25.6e6, 0.5, 2, 320, 160},
    }));
    core.parameters.clock_hz = static_cast<std::uint32_t>(clock);
    array.duty = duty;
    const Timer timer = choose_timer(array, core);
    REQUIRE(timer.prescaler == prescaler);
    REQUIRE(timer.cycle_ticks == cycle);
    REQUIRE(timer.pulse_ticks == pulse);
    REQUIRE(timer.carrier_hz() == Approx(40e3).epsilon(1e-4));
}

TEST_CASE("timer: a clock that cannot make the carrier is an error", "[focus]") {
    Core core;
    Array array;
    array.elements = {Element{}};
    core.parameters.clock_hz = 200'000;
    REQUIRE_REFUSED(choose_timer(array, core));
    core.parameters.clock_hz = 48'000'000;
    core.parameters.timing_bits = 8;
    REQUIRE(choose_timer(array, core).prescaler == 5);  // 240 ticks: the finest that 8 bits can hold
}

TEST_CASE("timer: every tick of the cycle is a timing that the board can hold", "[focus]") {
    Core core;
    Array array;
    array.elements = {Element{}};
    array.duty = 0.2;  // so that the pulse counter does not bound it first
    const auto [clock, bits, prescaler, cycle] = GENERATE(table<double, unsigned, unsigned, unsigned>({
        {48e6, 16, 1, 1200},
        {48e6, 11, 1, 1200},
        {48e6, 10, 2, 600},
        {48e6, 9, 3, 400},
        {48e6, 8, 5, 240},
        {40e3 * 511, 9, 1, 511},  // the last tick is 510; 511 is all ones, which is silence
        {40e3 * 512, 9, 2, 256},
    }));
    core.parameters.clock_hz = static_cast<std::uint32_t>(clock);
    core.parameters.timing_bits = bits;
    const Timer timer = choose_timer(array, core);
    REQUIRE(timer.prescaler == prescaler);
    REQUIRE(timer.cycle_ticks == cycle);
    REQUIRE(timer.cycle_ticks - 1U < (1U << bits) - 1U);
}

TEST_CASE("timer: too few timing bits is an error that says so", "[focus]") {
    Core core;
    Array array;
    array.elements = {Element{}};
    core.parameters.clock_hz = 40'000 * 17 * 19;  // 17 and 19 ticks are what a whole prescaler leaves, and 323
    core.parameters.timing_bits = 4;
    REQUIRE_REFUSED(choose_timer(array, core));
    core.parameters.timing_bits = 5;
    REQUIRE(choose_timer(array, core).cycle_ticks == 19);
}

TEST_CASE("formation: the paper's geometry, as recomputed", "[focus]") {
    const Core core;
    Array array = find_array("tile-10x10");
    array.medium.speed_m_s = 340.0;
    // 10 cm above the centre: 53.8 µs, not the paper's 643 µs (which is what it measured, ring-up included).
    const Formation above = formation(array, core, from_mm(0, 0, 100));
    REQUIRE(above.flight_spread_s == Approx(53.8e-6).margin(0.1e-6));
    REQUIRE(above.periods == 3);
    REQUIRE(above.formation_s == Approx(3.0 / 40e3 + 107.0 / 50e6));
    // A board that computes foci takes longer, and one with amplitudes a clock more for each channel's words.
    const Core wide = find_configuration("tile-100-wide");
    REQUIRE(formation(array, wide, from_mm(0, 0, 100)).formation_s == Approx(3.0 / 40e3 + 108.0 / 50e6));
    REQUIRE(formation(array, wide, from_mm(0, 0, 100), 1).formation_s == Approx(3.0 / 40e3 + 164.0 / 50e6));
    REQUIRE(formation(array, wide, from_mm(0, 0, 100), 8).formation_s == Approx(3.0 / 40e3 + 874.0 / 50e6));
    REQUIRE(above.ring_up_s == Approx(366e-6).margin(1e-6));
    REQUIRE(formation(array, core, from_mm(200, 200, 100)).flight_spread_s == Approx(352e-6).margin(3e-6));
    // The paper's eq. 13 with its own numbers: 26 periods, 30 Hz.
    REQUIRE(most_points(30.0, 26.0 / 40e3 + 108.0 / 50e6) == 51);
    const std::vector<Vec3> foci = {from_mm(0, 0, 100), from_mm(50, 0, 100)};
    REQUIRE(slowest_formation(array, core, foci).flight_spread_s == formation(array, core, foci[1]).flight_spread_s);
}
