// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "../refusal.hpp"
#include "every_target.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/solve/focal_law.hpp"

using namespace haptogram;

namespace {

using Generator = std::mt19937_64;

/// The law as its header says it, one value after the other in double precision, with the standard library's rounding.
std::vector<std::uint16_t> plain_law(const Array& array, const Timer& timer, const std::vector<Vec3>& foci) {
    const double ticks_per_m = 1.0 / (array.medium.speed_m_s * timer.tick_s());
    std::vector<std::uint16_t> ticks;
    ticks.reserve(foci.size() * array.elements.size());
    std::vector<double> ranges(array.elements.size());
    for (const Vec3& focus : foci) {
        double farthest = 0.0;
        for (std::size_t m = 0; m < ranges.size(); ++m) {
            const Vec3 ray = focus - array.elements[m].position;
            ranges[m] = std::sqrt((ray.x * ray.x + ray.y * ray.y) + ray.z * ray.z);
            farthest = std::max(farthest, ranges[m]);
        }
        for (const double range : ranges)
            ticks.push_back(static_cast<std::uint16_t>(std::llround((farthest - range) * ticks_per_m) %
                                                       static_cast<long long>(timer.cycle_ticks)));
    }
    return ticks;
}

std::vector<Vec3> random_foci(Generator& g, std::size_t count, double lateral, double low, double high) {
    std::uniform_real_distribution<double> xy(-lateral, lateral), z(low, high);
    std::vector<Vec3> foci(count);
    for (Vec3& focus : foci) focus = {xy(g), xy(g), z(g)};
    return foci;
}

Timer timer_of(std::uint32_t cycle_ticks) {
    Timer timer;
    timer.prescaler = 1;
    timer.cycle_ticks = cycle_ticks;
    timer.clock_hz = 40e3 * cycle_ticks;
    return timer;
}

std::size_t differing(const std::vector<std::uint16_t>& a, const std::vector<std::uint16_t>& b) {
    REQUIRE(a.size() == b.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i] ? 1U : 0U;
    return count;
}

Array without_grid(std::size_t elements, Generator& g) {
    std::uniform_real_distribution<double> xy(-0.06, 0.06), z(-0.01, 0.01);
    Array array;
    for (std::size_t m = 0; m < elements; ++m) array.elements.push_back({{xy(g), xy(g), z(g)}});
    return array;
}

}  // namespace

TEST_CASE("focal law: a million ticks equal to double precision, on every instruction set", "[focus]") {
    const char* const name = GENERATE("tile-10x10", "hoshi-18x18", "tile-7x8");
    const std::uint32_t cycle = GENERATE(8U, 250U, 640U, 1250U);
    CAPTURE(name, cycle, Catch::rngSeed());
    const Array array = find_array(name);
    Generator g(Catch::rngSeed());
    const std::vector<Vec3> foci = random_foci(g, 1'000'000 / array.elements.size() + 1, 0.08, 0.03, 0.3);
    const auto expected = plain_law(array, timer_of(cycle), foci);
    on_every_target(focal_law_target,
                    [&] { REQUIRE(differing(focal_law(array, timer_of(cycle), foci), expected) == 0); });
}

TEST_CASE("focal law: a hundred million ticks equal to double precision", "[focus]") {
    CAPTURE(Catch::rngSeed());
    const Array array = find_array("tile-10x10");
    Generator g(Catch::rngSeed());
    for (int part = 0; part < 10; ++part) {
        const Timer timer = timer_of(part % 2 == 0 ? 250 : 1250);
        const std::vector<Vec3> foci = random_foci(g, 100'000, 0.1, 0.02, 0.4);
        REQUIRE(differing(focal_law(array, timer, foci), plain_law(array, timer, foci)) == 0);
    }
}

TEST_CASE("focal law: exact for foci near, far, behind, beside and in the array, and for every cycle", "[focus]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = find_array("tile-10x10");
    const Vec3 element = array.elements[37].position;
    std::vector<Vec3> foci{element,
                           element + Vec3{0.0, 0.0, 1e-12},
                           element + Vec3{0.0, 0.0, 1e-6},
                           {0.0, 0.0, 0.0},
                           {0.0, 0.0, -0.15},
                           {0.3, 0.0, 0.0},
                           {0.0, 0.0, 5.0},
                           {600.0, -700.0, 1000.0},
                           {1e-300, 0.0, 0.15}};
    for (const Vec3& focus : random_foci(g, 300, 2.0, -2.0, 2.0)) foci.push_back(focus);
    for (const std::uint32_t cycle : {1U, 2U, 3U, 7U, 255U, 511U, 512U, 513U, 4096U, 16383U, 32767U, 32768U, 65535U}) {
        CAPTURE(cycle);
        const auto expected = plain_law(array, timer_of(cycle), foci);
        on_every_target(focal_law_target,
                        [&] { REQUIRE(differing(focal_law(array, timer_of(cycle), foci), expected) == 0); });
    }
}

TEST_CASE("focal law: exact where delays fall on the middle between two ticks", "[focus]") {
    // Two elements on the x axis, and foci on it beyond both: the delay is the elements' distance in ticks, whatever
    // the focus. With 2⁻²⁰ s a tick and 2⁻¹⁰·2²⁰ m/s, distances are exact in double precision.
    Array array;
    array.medium.speed_m_s = 1024.0;
    Timer timer;
    timer.clock_hz = 0x1p20;
    timer.prescaler = 1;
    timer.cycle_ticks = 250;
    const double tick_m = 0x1p-10;
    for (int half = 1; half < 2000; half += 2) {
        array.elements = {{{0.0, 0.0, 0.0}}, {{half * 0.5 * tick_m, 0.0, 0.0}}};
        const std::vector<Vec3> foci{{2.0, 0.0, 0.0}};
        const auto expected = static_cast<std::uint16_t>((half + 1) / 2 % 250);  // halves up
        on_every_target(focal_law_target, [&] {
            REQUIRE(focal_law(array, timer, foci) == std::vector<std::uint16_t>{0, expected});
        });
    }
}

TEST_CASE("focal law: exact for arrays that are no grid, for rigs, and for any number of elements", "[focus]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array tile = find_array("tile-10x10");
    std::vector<Array> arrays{without_grid(249, g)};
    arrays.push_back(joined(
        {"facing",
         {{tile, pose_of({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0})}, {tile, pose_of({0.0, 0.0, 0.3}, {180.0, 0.0, 0.0})}}}));
    arrays.push_back(joined(
        {"beside",
         {{tile, pose_of({-0.1, 0.0, 0.0}, {0.0, 20.0, 0.0})}, {tile, pose_of({0.1, 0.0, 0.0}, {0.0, -20.0, 5.0})}}}));
    Array line = tile;
    line.elements.resize(10);
    arrays.push_back(line);
    Array twice = tile;  // every element twice, and once more a hair away
    for (const Element& e : tile.elements) twice.elements.push_back(e);
    for (const Element& e : tile.elements) twice.elements.push_back({e.position + Vec3{1e-9, -1e-9, 0.0}, e.normal});
    arrays.push_back(twice);
    for (const double width_m : {0.26, 0.28, 1.2}) {  // beyond 32 cycles of 250 ticks single precision counts in ticks
        Array wide = without_grid(300, g);
        for (Element& e : wide.elements) e.position.x *= width_m / 0.12;
        arrays.push_back(wide);
    }
    for (const std::size_t count : {1U, 2U, 3U, 5U, 15U, 16U, 17U, 31U, 33U, 63U, 64U, 65U, 127U, 129U, 500U})
        arrays.push_back(without_grid(count, g));
    for (const Array& array : arrays)
        for (const std::size_t count : {1U, 2U, 63U, 64U, 65U, 300U}) {
            CAPTURE(array.name, array.elements.size(), count);
            const std::vector<Vec3> foci = random_foci(g, count, 0.1, 0.05, 0.25);
            const auto expected = plain_law(array, timer_of(250), foci);
            on_every_target(focal_law_target,
                            [&] { REQUIRE(differing(focal_law(array, timer_of(250), foci), expected) == 0); });
        }
}

TEST_CASE("focal law: says which focus or element it cannot use, and what room it needs", "[focus]") {
    Array array = find_array("tile-10x10");
    const Timer timer = timer_of(250);
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    for (const double bad : {nan, infinite, -infinite, 1000.1}) {
        const std::vector<Vec3> foci{{0.0, 0.0, 0.1}, {0.0, bad, 0.1}};
        REQUIRE_REFUSED(focal_law(array, timer, foci));
    }
    const std::vector<Vec3> foci{{0.0, 0.0, 0.1}};
    std::vector<std::uint16_t> ticks(99);
    REQUIRE_REFUSED(focal_law(array, timer, foci, ticks));
    array.elements[4].position.z = nan;
    REQUIRE_REFUSED(focal_law(array, timer, foci));
}
