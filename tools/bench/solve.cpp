// SPDX-License-Identifier: Apache-2.0
// Measures the focal law and the fast solver for tools/bench.py, on every instruction set of this processor, on one
// thread; prints one JSON object. Times are the least of several runs, as other programs only add to them.
#include <fmt/core.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>

#include "haptogram/solve/fast_solver.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "least.hpp"

namespace {

using namespace haptogram;
using bench::least_s;
using Foci = std::vector<Focus>;

Timer timer_of(std::uint32_t cycle_ticks) {
    Timer timer;
    timer.prescaler = 1;
    timer.cycle_ticks = cycle_ticks;
    timer.clock_hz = 40e3 * cycle_ticks;
    return timer;
}

double focal_law_ms(std::uint32_t cycle_ticks) {
    const Array array = find_array("tile-10x10");
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> lateral(-0.05, 0.05);
    std::vector<Vec3> foci(100'000);
    for (Vec3& f : foci) f = {lateral(generator), lateral(generator), 0.13 + lateral(generator)};
    std::vector<std::uint16_t> ticks(foci.size() * array.elements.size());
    return 1e3 * least_s(15, [&] { focal_law(array, timer_of(cycle_ticks), foci, ticks); });
}

Array grid_of(int columns, int rows, double pitch) {
    Array array;
    for (int m = 0; m < columns * rows; ++m)
        array.elements.push_back(
            {{(m % columns - (columns - 1) / 2.0) * pitch, (m / columns - (rows - 1) / 2.0) * pitch, 0.0}});
    return array;
}

/// The 18 × 14 − 3 elements of an AUTD unit.
Array autd() {
    Array array = grid_of(18, 14, 0.01016);
    for (const int missing : {18 + 16, 18 + 2, 18 + 1}) array.elements.erase(array.elements.begin() + missing);
    return array;
}

constexpr double apart_m = 0.015, half_m = 0.06;

bool free_for(const Foci& foci, std::size_t k, Vec3 at) {
    if (std::abs(at.x) > half_m || std::abs(at.y) > half_m) return false;
    for (std::size_t j = 0; j < foci.size(); ++j)
        if (j != k && distance(foci[j].position, at) < apart_m) return false;
    return true;
}

std::vector<Foci> random_sets(std::size_t sets, std::size_t count, std::mt19937& generator) {
    std::uniform_real_distribution<double> lateral(-half_m, half_m);
    std::vector<Foci> found;
    while (found.size() < sets) {
        Foci foci;
        for (int tries = 0; tries < 20'000 && foci.size() < count; ++tries) {
            const Vec3 at{lateral(generator), lateral(generator), 0.15};
            if (free_for(foci, foci.size(), at)) foci.push_back({at});
        }
        if (foci.size() == count) found.push_back(foci);
    }
    return found;
}

/// Frames in which each focus has gone on by 0.2 mm, turning where the way is blocked.
std::vector<Foci> frames_from(Foci foci, std::size_t frames, std::mt19937& generator) {
    std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
    std::vector<double> heading(foci.size());
    for (double& h : heading) h = angle(generator);
    std::vector<Foci> found;
    while (found.size() < frames) {
        for (std::size_t k = 0; k < foci.size(); ++k)
            for (int tries = 0; tries < 100; ++tries) {
                const Vec3 to = foci[k].position + 2e-4 * Vec3{std::cos(heading[k]), std::sin(heading[k]), 0.0};
                if (free_for(foci, k, to)) {
                    foci[k].position = to;
                    break;
                }
                heading[k] = angle(generator);
            }
        found.push_back(foci);
    }
    return found;
}

std::vector<std::complex<double>> drives_of(const std::vector<std::uint16_t>& ticks, std::uint32_t cycle) {
    std::vector<std::complex<double>> drives;
    for (const std::uint16_t tick : ticks) drives.push_back(std::polar(1.0, -2.0 * std::numbers::pi * tick / cycle));
    return drives;
}

struct Sample {
    std::vector<double> values;
    void add(double value) { values.push_back(value); }
    double at(double share) {
        std::sort(values.begin(), values.end());
        return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    }
};

/// Sets of foci from nothing: time with the rounding to 250 ticks, and quality after it.
nlohmann::ordered_json cold(const Array& array, std::size_t count) {
    std::mt19937 generator(11);
    const std::vector<Foci> sets = random_sets(100, count, generator);
    const Timer timer = timer_of(250);
    FastSolver solver(array, count);
    std::vector<std::uint16_t> ticks(array.elements.size());
    Sample spread, efficiency;
    for (const Foci& foci : sets) {
        solver.solve(foci);
        solver.ticks(timer, ticks);
        const Quality quality = quality_of(array, foci, drives_of(ticks, 250));
        spread.add(quality.spread);
        efficiency.add(quality.efficiency);
    }
    const double s = least_s(50, [&] {
        for (const Foci& foci : sets) {
            solver.solve(foci);
            solver.ticks(timer, ticks);
        }
    });
    return {{"us", 1e6 * s / static_cast<double>(sets.size())},
            {"spread", spread.at(0.5)},
            {"worst_spread", spread.at(1.0)},
            {"efficiency", efficiency.at(0.5)}};
}

/// A thousand frames of moving foci, each begun from the last: time with the rounding to 250 ticks; quality of the
/// exact phases, and at the end beside that of solving from nothing.
nlohmann::ordered_json warm(const Array& array, std::size_t count) {
    std::mt19937 generator(5);
    const Foci begin = random_sets(1, count, generator).front();
    const std::vector<Foci> frames = frames_from(begin, 1000, generator);
    const Timer timer = timer_of(250);
    FastSolver solver(array, count), fresh(array, count);
    std::vector<std::uint16_t> ticks(array.elements.size());
    Sample spread;
    double followed = 0.0, solved = 0.0;
    solver.solve(begin);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        solver.follow(frames[i]);
        const Quality quality = quality_of(array, frames[i], solver.drives());
        spread.add(quality.spread);
        if (i < 900) continue;
        fresh.solve(frames[i]);
        followed += quality.efficiency;
        solved += quality_of(array, frames[i], fresh.drives()).efficiency;
    }
    const double s = least_s(50, [&] {
        solver.solve(begin);
        for (const Foci& foci : frames) {
            solver.follow(foci);
            solver.ticks(timer, ticks);
        }
    });
    return {{"us", 1e6 * s / static_cast<double>(frames.size())},
            {"spread", spread.at(0.5)},
            {"worst_spread", spread.at(1.0)},
            {"efficiency_over_solved", followed / solved}};
}

nlohmann::ordered_json on_this_target() {
    return {{"target", focal_law_target()},
            {"focal_law_250_ms", focal_law_ms(250)},
            {"focal_law_1250_ms", focal_law_ms(1250)},
            {"10x249", cold(autd(), 10)},
            {"16x256", cold(grid_of(16, 16, 0.0105), 16)},
            {"32x249", cold(autd(), 32)},
            {"10x249_warm", warm(autd(), 10)}};
}

}  // namespace

int main() try {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    // The best first; below AVX2 and its like nobody waits for microseconds.
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0 && json.size() < 2; targets &= targets - 1) {
        const std::int64_t target = targets & -targets;
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        if (std::string(focal_law_target()) == hwy::TargetName(target)) json.push_back(on_this_target());
    }
    fmt::print("{}\n", json.dump());
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "measure_solve: {}\n", error.what());
    return 1;
}
