// SPDX-License-Identifier: Apache-2.0
// Four tiles of the Haptogram paper side by side, and Hoshi's nine units, a Verilated board each, and what their pins
// make of the air.
#include <fmt/format.h>

#include <complex>
#include <numbers>

#include "bench.hpp"
#include "haptogram/acoustics/drive.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/solve/focal_law.hpp"

using namespace haptogram;
using namespace haptogram::test;

namespace {

/// Square arrays side by side, row by row.
Rig wall_of(const char* array, const std::vector<double>& places) {
    Rig rig{"wall", {}};
    for (const double y : places)
        for (const double x : places) rig.arrays.push_back({find_array(array), pose_of({x, y, 0.0}, {})});
    return rig;
}

/// Gathers each element's pulses in the time that all boards share.
struct Pulses {
    std::vector<std::vector<DrivePulse>> of_element;
    std::vector<double> rise;
    double from_s = 0.0, to_s = 0.0;

    Pulses(sim::Tiles& tiles, std::size_t per_tile)
        : of_element(tiles.size() * per_tile), rise(of_element.size(), -1.0) {
        for (std::size_t tile = 0; tile < tiles.size(); ++tile)
            tiles.board(tile).on_edge([this, &tiles, tile, per_tile](const sim::Edge& edge) {
                const std::size_t element = tile * per_tile + edge.channel;
                const double now = static_cast<double>(tiles.now()) * 1e-15;
                if (edge.rises)
                    rise[element] = now;
                else if (rise[element] >= from_s && rise[element] < to_s)
                    of_element[element].push_back({rise[element] - from_s, now - from_s});
            });
    }
};

/// Where the pressure is greatest, near a point.
Vec3 peak_near(const Array& array, const std::vector<std::complex<double>>& drives, Vec3 at) {
    const auto level = [&](Vec3 p) { return std::abs(pressure(array, drives, p)); };
    double best = level(at);
    for (double step = 1e-3; step > 1e-6;) {
        bool moved = false;
        for (const Vec3 d : {Vec3{step, 0, 0}, Vec3{-step, 0, 0}, Vec3{0, step, 0}, Vec3{0, -step, 0}, Vec3{0, 0, step},
                             Vec3{0, 0, -step}})
            if (const double there = level(at + d); there > best) best = there, at = at + d, moved = true;
        if (!moved) step /= 2;
    }
    return at;
}

/// Boards of this model, as many as the rig has arrays, make a focus at random.
void check_focus(const Rig& rig, const char* model, std::uint32_t clock_hz) {
    const std::uint32_t cycle = clock_hz / 40'000, length = cycle / 5;
    std::mt19937 g(Catch::rngSeed());
    const std::size_t tiles = rig.arrays.size(), per_tile = rig.arrays[0].array.elements.size();
    const Array wall = joined(rig);
    const Timer timer{static_cast<double>(clock_hz), 1, cycle, length};
    std::uniform_real_distribution<double> sideways(-0.03, 0.03), up(0.15, 0.25);
    const Vec3 focus{sideways(g), sideways(g), up(g)};
    REQUIRE(wall.unreachable(focus).empty());
    const std::vector<Vec3> foci = {focus};
    const std::vector<std::uint16_t> ticks = focal_law(wall, timer, foci);

    const std::vector<sim::Oscillator> oscillators = crystals(tiles, 50.0, 0.0, g);
    TileBench bench(model, oscillators, Catch::rngSeed());
    Pulses pulses(bench.tiles, per_tile);
    for (std::size_t tile = 0; tile < tiles; ++tile) {
        const auto first = ticks.begin() + static_cast<std::ptrdiff_t>(tile * per_tile);
        Image image;
        image.channels = static_cast<std::uint32_t>(per_tile);
        image.clock_hz = clock_hz;
        image.records.push_back({cycle, 1, static_cast<std::uint8_t>(length),
                                 std::vector<std::uint16_t>(first, first + static_cast<std::ptrdiff_t>(per_tile))});
        bench.load(tile, primary_words(image));
    }
    bench.join();
    bench.play(1);
    // 40 of the master's cycles, half of which are a clock longer.
    const double master_hz = clock_hz * (1.0 + oscillators[0].offset_ppm * 1e-6);
    constexpr int cycles = 40;
    const double period_s = (cycle + 0.5) / master_hz;
    pulses.from_s = static_cast<double>(bench.tiles.now()) * 1e-15;
    pulses.to_s = pulses.from_s + (cycles + 1) * period_s;  // a pulse may begin just at either end
    bench.run_ms((cycles + 3) * 0.025);

    std::vector<std::complex<double>> drives, exact = ideal_drives(wall, focus);
    for (const auto& train : pulses.of_element) {
        REQUIRE(train.size() >= cycles);
        REQUIRE(train.size() <= cycles + 2);
        const std::vector<DrivePulse> first(train.begin(), train.begin() + cycles);
        drives.push_back(wall.transducer.source_pa_m * carrier_component(first, 1.0 / period_s, cycles * period_s));
    }
    for (auto& drive : exact) drive *= std::sin(std::numbers::pi * length / cycle);
    const double made = std::abs(pressure(wall, drives, focus)), perfect = std::abs(pressure(wall, exact, focus));
    const Vec3 made_at = peak_near(wall, drives, focus), perfect_at = peak_near(wall, exact, focus);
    const double off = distance(made_at, perfect_at);
    fmt::print(
        "tiles: seed {}, focus at ({:.1f}, {:.1f}, {:.1f}) mm: {:.4f} % of the pressure of a perfect array, peak "
        "{:.4f} mm beside its peak\n",
        Catch::rngSeed(), focus.x * 1e3, focus.y * 1e3, focus.z * 1e3, 100.0 * made / perfect, off * 1e3);
    CHECK(made >= 0.995 * perfect);
    CHECK(off <= 0.2e-3);
}

}  // namespace

TEST_CASE("contract 11, together: four tiles make the focus of one array of 400 elements") {
    check_focus(wall_of("tile-10x10", {-0.05, 0.05}), "tile-100-wide", 50'000'000);
}

TEST_CASE("contract 11, together: nine units make the focus of Hoshi's array of 324 elements") {
    check_focus(wall_of("hoshi-6x6", {-0.06, 0.0, 0.06}), "unit-36", 25'600'000);
}
