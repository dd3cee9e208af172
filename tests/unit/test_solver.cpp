// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "every_target.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/even.hpp"
#include "haptogram/solve/fast_solver.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "haptogram/solve/solver.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "haptogram/verbs/measure.hpp"
#include "haptogram/verbs/solve.hpp"

using namespace haptogram;

namespace {

using Generator = std::mt19937_64;
using DriveList = std::vector<std::complex<double>>;

Array grid_of(std::uint32_t columns, std::uint32_t rows, double pitch) {
    Array array;
    array.columns = columns;
    for (std::uint32_t m = 0; m < columns * rows; ++m)
        array.elements.push_back(
            {{(m % columns - (columns - 1) / 2.0) * pitch, (m / columns - (rows - 1) / 2.0) * pitch, 0.0}});
    return array;
}

/// Foci that are no nearer to each other than a focus is wide.
std::vector<Focus> random_foci(Generator& g, std::size_t count, double z = 0.15, double half = 0.06) {
    std::uniform_real_distribution<double> lateral(-half, half);
    for (;;) {
        std::vector<Focus> foci;
        for (int tries = 0; tries < 5000 && foci.size() < count; ++tries) {
            const Vec3 at{lateral(g), lateral(g), z};
            if (std::none_of(foci.begin(), foci.end(),
                             [&](const Focus& f) { return distance(f.position, at) < 0.015; }))
                foci.push_back({at});
        }
        if (foci.size() == count) return foci;
    }
}

/// Pressures at the foci by the code that computes fields, which knows nothing of solvers.
std::vector<double> made(const Array& array, const std::vector<Focus>& foci, DriveList drives) {
    std::vector<Vec3> points;
    for (const Focus& focus : foci) points.push_back(focus.position);
    for (auto& drive : drives) drive *= array.transducer.source_pa_m;
    std::vector<double> found;
    for (const auto& p : pressure_at(array, drives, points)) found.push_back(std::abs(p));
    return found;
}

/// The most that the array can make at a point.
double most(const Array& array, Vec3 point) { return std::abs(pressure(array, ideal_drives(array, point), point)); }

double spread(const std::vector<double>& values) {
    double mean = 0.0, variance = 0.0;
    for (const double v : values) mean += v / static_cast<double>(values.size());
    for (const double v : values) variance += (v - mean) * (v - mean) / static_cast<double>(values.size());
    return std::sqrt(variance) / mean;
}

SolveOptions by(Method method, bool amplitudes = false) {
    SolveOptions options;
    options.method = method;
    options.amplitudes = amplitudes;
    return options;
}

}  // namespace

TEST_CASE("solver: for one focus every method but one gives the focal law's ticks", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = find_array("tile-10x10");
    const Timer timer;
    std::uniform_real_distribution<double> lateral(-0.05, 0.05), height(0.06, 0.25);
    for (int repeat = 0; repeat < 20; ++repeat) {
        const Focus focus{{lateral(g), lateral(g), height(g)}};
        const auto law = focal_law(array, timer, {&focus.position, 1});
        const auto first = static_cast<std::size_t>(std::max_element(array.elements.begin(), array.elements.end(),
                                                                     [&](const Element& a, const Element& b) {
                                                                         return distance(a, focus.position) <
                                                                                distance(b, focus.position);
                                                                     }) -
                                                    array.elements.begin());
        for (const MethodName& one : method_names) {
            if (one.method == Method::inverse_transform) continue;  // exact on the axis only, which is tested below
            CAPTURE(one.name);
            const auto drives = solve(array, {&focus, 1}, by(one.method));
            REQUIRE(quality_of(array, {&focus, 1}, drives).efficiency == Approx(1.0).epsilon(1e-12));
            int different = 0;
            const double turn = std::arg(drives[first]);  // the common phase is free; the law gives the farthest 0
            for (std::size_t m = 0; m < drives.size(); ++m) {
                const double exact = -(std::arg(drives[m]) - turn) / (2.0 * std::numbers::pi) * timer.cycle_ticks;
                const double off = std::remainder(exact - law[m], timer.cycle_ticks);
                if (std::abs(off) > 0.5 + 1e-6) ++different;
            }
            REQUIRE(different == 0);
        }
    }
    const Focus axis{{0.0, 0.0, 0.15}};
    REQUIRE(quality_of(array, {&axis, 1}, solve(array, {&axis, 1}, by(Method::inverse_transform))).efficiency ==
            Approx(1.0).epsilon(1e-12));
}

TEST_CASE("solver: a lone focus at any round place has all that every shipped array can make there", "[solver]") {
    // At some round places the phases of all elements are the focus' to the last bit.
    int silent = 0, weak = 0;
    for (const std::string& name : shipped_arrays()) {
        const Array array = find_array(name);
        FastSolver fast(array, 1);
        for (int x = -50; x <= 50; x += 10)
            for (int y = -50; y <= 50; y += 10)
                for (int z = 100; z <= 200; z += 10) {
                    const Focus focus{from_mm(x, y, z)};
                    DriveList row;
                    double most_here = 0.0;
                    for (const Element& element : array.elements) {
                        row.push_back(propagation(array, element, focus.position));
                        most_here += std::abs(row.back());
                    }
                    const auto share = [&](const DriveList& drives) {
                        std::complex<double> sum = 0.0;
                        for (std::size_t m = 0; m < row.size(); ++m) sum += drives[m] * row[m];
                        return std::abs(sum) / most_here;
                    };
                    CAPTURE(name, x, y, z);
                    for (const MethodName& one : method_names) {
                        SolveOptions options = by(one.method);
                        options.rounds = 2;
                        const double made = share(solve(array, {&focus, 1}, options));
                        CAPTURE(one.name, made);
                        if (!(made > 1e-6)) ++silent;
                        if (one.method != Method::inverse_transform && !(made > 1.0 - 1e-9)) ++weak;
                    }
                    fast.solve({&focus, 1});
                    if (!(share(fast.drives()) > 1.0 - 1e-5)) ++weak;
                }
    }
    CAPTURE(silent, weak);
    REQUIRE(silent == 0);
    REQUIRE(weak == 0);
}

TEST_CASE("solver: silence where pressure was asked for is an error, and no number", "[solver]") {
    const Array array = find_array("tile-10x10");
    const Focus focus{{0.0, 0.0, 0.15}};
    REQUIRE_REFUSED(quality_of(array, {&focus, 1}, DriveList(100)));
    Array behind = array;
    behind.transducer.pattern = Pattern::table;
    behind.transducer.table = {1.0, 0.5};
    const std::vector<Vec3> below{{0.0, 0.0, -0.1}};
    for (const MethodName& one : method_names)
        if (one.method != Method::inverse_transform)
            REQUIRE_REFUSED(solve(behind, std::vector<Focus>{{below.front()}}, by(one.method)));
    REQUIRE_REFUSED(CrossTalk(behind, below));
}

TEST_CASE("solver: ten random foci come out equal by the default, and better than by the others", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = grid_of(18, 14, 0.01016);
    std::vector<double> worst(std::size(method_names)), efficiency(std::size(method_names));
    constexpr int sets = 20;
    for (int set = 0; set < sets; ++set) {
        const std::vector<Focus> foci = random_foci(g, 10);
        for (std::size_t i = 0; i < std::size(method_names); ++i) {
            const auto drives = solve(array, foci, by(method_names[i].method));
            for (const auto& drive : drives) REQUIRE(std::abs(drive) == Approx(1.0));
            std::vector<double> shares = made(array, foci, drives);
            const Quality quality = quality_of(array, foci, drives);
            for (std::size_t k = 0; k < foci.size(); ++k) {
                REQUIRE(quality.pressure_pa[k] == Approx(shares[k]).epsilon(1e-3));
                shares[k] /= most(array, foci[k].position);
            }
            REQUIRE(quality.spread == Approx(spread(shares)).margin(2e-4));
            worst[i] = std::max(worst[i], quality.spread);
            efficiency[i] += quality.efficiency / sets;
        }
    }
    CAPTURE(worst, efficiency);
    REQUIRE(worst[0] <= 0.002);
    REQUIRE(efficiency[0] >= 0.92);
    for (std::size_t i = 2; i < worst.size(); ++i) REQUIRE(worst[i] > 10.0 * worst[0]);
    // Weighted GS is equal, too, after enough rounds. All of them beat the plain sum, which Hoshi's transform does not.
    REQUIRE(worst[1] < 0.05);
    for (const std::size_t i : {0U, 1U, 2U, 3U}) REQUIRE(efficiency[i] > efficiency[4]);
}

TEST_CASE("solver: amplitudes are what was asked for, of the most that can be made or of the pressure", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = grid_of(16, 16, 0.0105);
    for (const bool amplitudes : {false, true})
        for (const Level level : {Level::reachable, Level::pressure}) {
            std::vector<Focus> foci = random_foci(g, 5);
            const double asked[] = {0.8, 0.4, 0.6, 0.2, 0.5};
            for (std::size_t k = 0; k < foci.size(); ++k) foci[k].amplitude = asked[k];
            SolveOptions options = by(Method::gauss_newton, amplitudes);
            options.level = level;
            options.rounds = 30;
            const auto drives = solve(array, foci, options);
            double strongest = 0.0;
            for (const auto& drive : drives) strongest = std::max(strongest, std::abs(drive));
            REQUIRE(strongest == Approx(0.8));  // the largest that was asked for
            std::vector<double> ratios = made(array, foci, drives);
            for (std::size_t k = 0; k < foci.size(); ++k)
                ratios[k] /= asked[k] * (level == Level::reachable ? most(array, foci[k].position) : 1.0);
            CAPTURE(amplitudes, static_cast<int>(level), ratios);
            REQUIRE(spread(ratios) <= 0.01);
            REQUIRE(quality_of(array, foci, drives, level).spread <= 0.01);
        }
}

TEST_CASE("solver: at a focus of amplitude 0 the pressure is held down", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = find_array("tile-10x10");
    for (const std::size_t count : {1U, 2U, 4U})
        for (const bool amplitudes : {false, true})
            for (const Level level : {Level::reachable, Level::pressure}) {
                // Nulls between the foci, where the field of the foci alone has its side lobes.
                std::vector<Focus> foci = random_foci(g, count + 2, 0.15, 0.04);
                const std::vector<Focus> alone(foci.begin(), foci.begin() + static_cast<std::ptrdiff_t>(count));
                for (std::size_t k = count; k < foci.size(); ++k) foci[k].amplitude = 0.0;
                SolveOptions options = by(Method::gauss_newton, amplitudes);
                options.level = level;
                const auto drives = solve(array, foci, options);
                const std::vector<double> held = made(array, foci, drives);
                CAPTURE(count, amplitudes, static_cast<int>(level), held);
                for (std::size_t k = count; k < foci.size(); ++k)
                    REQUIRE(held[k] < 1e-3 * most(array, foci[k].position));
                // The foci lose some of theirs by it, and stay even.
                const Quality quality = quality_of(array, foci, drives, level);
                const Quality free = quality_of(array, alone, solve(array, alone, options), level);
                REQUIRE(quality.spread < 0.01);
                REQUIRE(quality.efficiency > 0.6 * free.efficiency);
                REQUIRE(quality.null_share.value() < 1e-4);
                REQUIRE_FALSE(free.null_share);
            }
    // A null on the flank of the focus, a third of a wavelength away, costs most of it but is there.
    const std::vector<Focus> near{{from_mm(0, 0, 150)}, {from_mm(3, 0, 150), 0.0}};
    const Quality quality = quality_of(array, near, solve(array, near));
    REQUIRE(quality.null_share.value() < 1e-4);
    REQUIRE(quality.efficiency > 0.1);
    for (const MethodName& one : method_names)
        if (one.method != Method::gauss_newton) REQUIRE_REFUSED(solve(array, near, by(one.method)));
}

TEST_CASE("compile: a path's focus of amplitude 0 is held down by records, and refused by boards that add up",
          "[solver]") {
    const Path path{{{{{from_mm(10, 0, 150)}, {from_mm(-10, 0, 150), 0.0}}, 40}}, {}};
    const Array array = find_array("tile-10x10");
    const Compiled compiled = compile(path, array, find_configuration("tile-100"));
    const Manifest manifest = manifest_from_json(to_text(compiled.bundle.manifest), "test");
    REQUIRE(manifest.points().size() == 1);
    const DriveList drives = drives_of(manifest, compiled.bundle.image.records[0]);
    const double at_focus = std::abs(pressure(array, drives, path.steps[0].foci[0].position));
    const double at_null = std::abs(pressure(array, drives, path.steps[0].foci[1].position));
    REQUIRE(at_focus > 0.9 * most(array, path.steps[0].foci[0].position));
    REQUIRE(at_null < 0.005 * at_focus);  // 250 ticks a period
    const FocusCheck check = check_record(manifest, manifest.records[0], drives);
    REQUIRE(check.pressure_kept > 0.999);
    REQUIRE(check.peak_offset_m < 1e-4);
    const Core adds_up = find_configuration("tile-100-wide");
    REQUIRE_REFUSED(compile(path, array, adds_up));
    Path padded = path;
    padded.steps[0].foci[1].position = padded.steps[0].foci[0].position;
    REQUIRE(compile(padded, array, adds_up).bundle.image.foci.value().each == 1);
}

TEST_CASE("solver: mirrored foci give mirrored drives", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = find_array("tile-10x10");
    for (const MethodName& one : method_names) {
        const std::vector<Focus> foci = random_foci(g, 4);
        std::vector<Focus> mirrored = foci;
        for (Focus& focus : mirrored) focus.position.x = -focus.position.x;
        const auto drives = solve(array, foci, by(one.method)), others = solve(array, mirrored, by(one.method));
        CAPTURE(one.name);
        for (std::size_t row = 0; row < 10; ++row)
            for (std::size_t column = 0; column < 10; ++column)
                REQUIRE(std::abs(drives[10 * row + column] - others[10 * row + 9 - column]) < 1e-6);
    }
}

TEST_CASE("solver: Hoshi's transform of two spots, summed over exact spherical waves", "[solver]") {
    // 18 × 18 point sources 10 mm apart, c = 340 m/s, spots asked for at ±20 mm, 200 mm away. The same sum in numpy
    // makes the spots at ±22.4 mm with 0.516 of a single focus' pressure, and 0.049 of it in the middle.
    Array array = grid_of(18, 18, 0.01);
    array.medium.speed_m_s = 340.0;
    array.transducer.pattern = Pattern::point;
    const std::vector<Focus> foci{{from_mm(-20, 0, 200)}, {from_mm(20, 0, 200)}};
    auto drives = solve(array, foci, by(Method::inverse_transform, true));
    for (auto& drive : drives) drive *= array.transducer.source_pa_m;
    const double single = most(array, from_mm(0, 0, 200));
    double highest = 0.0, where = 0.0;
    for (double x = 10.0; x < 35.0; x += 0.1) {
        const double p = std::abs(pressure(array, drives, from_mm(x, 0, 200)));
        if (p > highest) {
            highest = p;
            where = x;
        }
    }
    REQUIRE(where == Approx(22.4).margin(0.11));
    REQUIRE(highest / single == Approx(0.5162).margin(0.0002));
    REQUIRE(std::abs(pressure(array, drives, from_mm(0, 0, 200))) / single == Approx(0.0494).margin(0.0002));
}

TEST_CASE("solver: the sum of Fingers, with amplitudes and without, beside weighted GS", "[solver]") {
    // 10 × 10 point sources 10 mm apart, foci at (±15, 0, 150) mm, over the single focus at (0, 0, 150) mm. Independent
    // numbers: 0.522 with amplitudes, 0.670 by phases alone, 0.671 by weighted GS; four foci on a circle of 20 mm 0.445
    // and 0.492.
    Array array = grid_of(10, 10, 0.01);
    array.transducer.pattern = Pattern::point;
    const double single = most(array, from_mm(0, 0, 150));
    const auto share = [&](const std::vector<Focus>& foci, const SolveOptions& options) {
        const Quality quality = quality_of(array, foci, solve(array, foci, options));
        REQUIRE(quality.spread < 1e-6);  // by symmetry
        return quality.pressure_pa.front() / single;
    };
    const std::vector<Focus> two{{from_mm(-15, 0, 150)}, {from_mm(15, 0, 150)}};
    REQUIRE(share(two, by(Method::distance_weighted, true)) == Approx(0.522).margin(0.001));
    REQUIRE(share(two, by(Method::distance_weighted)) == Approx(0.670).margin(0.001));
    REQUIRE(share(two, by(Method::weighted_gs)) == Approx(0.671).margin(0.002));
    REQUIRE(share(two, by(Method::gauss_newton)) == Approx(0.671).margin(0.002));
    const std::vector<Focus> four{
        {from_mm(-20, 0, 150)}, {from_mm(20, 0, 150)}, {from_mm(0, -20, 150)}, {from_mm(0, 20, 150)}};
    REQUIRE(share(four, by(Method::distance_weighted)) == Approx(0.445).margin(0.002));
}

TEST_CASE("solver: what is said of ticks is what the record's pulses make, of whole ticks in length, too", "[solver]") {
    const Array array = find_array("tile-10x10");
    const Core core = find_configuration("tile-100");
    for (const double amplitude : {1.0, 0.3, 0.05}) {
        const std::vector<std::vector<Focus>> sets{
            {{from_mm(0, 0, 150), amplitude}}, {{from_mm(-20, 0, 150), amplitude}, {from_mm(20, 5, 150), amplitude}}};
        const Solved solved = solve_steps(sets, array, core, {}, false);
        // The Fourier component of the record's pulses, as one would measure it at the pins.
        Manifest manifest;
        manifest.array = array;
        manifest.timer = solved.timer;
        for (const SolvedStep& step : solved.steps) {
            const DriveList drives = drives_of(manifest, step.record);
            for (std::size_t k = 0; k < step.foci.size(); ++k)
                REQUIRE(step.quantised.pressure_pa[k] ==
                        Approx(std::abs(pressure(array, drives, step.foci[k].position))).epsilon(1e-9));
        }
    }
    REQUIRE_REFUSED(solve_steps({{{from_mm(0, 0, 150), 1e-4}}}, array, core, {}, false));
}

TEST_CASE("solver: rigs and every pattern", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array tile = find_array("tile-10x10");
    const Rig rig{
        "facing",
        {{tile, pose_of({-0.1, 0.0, 0.0}, {0.0, 30.0, 0.0})}, {tile, pose_of({0.1, 0.0, 0.0}, {0.0, -30.0, 0.0})}}};
    Array array = joined(rig);
    for (const Pattern pattern : {Pattern::piston, Pattern::point, Pattern::table}) {
        array.transducer.pattern = pattern;
        array.transducer.table = {1, 1, 1, 0.891, 0.708, 0.501, 0.355, 0.251, 0.200, 0.178};
        const std::vector<Focus> foci = random_foci(g, 6, 0.15, 0.04);
        CAPTURE(static_cast<int>(pattern));
        REQUIRE(quality_of(array, foci, solve(array, foci)).spread <= 0.005);
        FastSolver fast(array, 6);
        fast.solve(foci);
        REQUIRE(quality_of(array, foci, fast.drives()).spread <= 0.005);
    }
    REQUIRE_REFUSED(solve(array, random_foci(g, 2), by(Method::inverse_transform)));
}

TEST_CASE("solver: beginning from the last drives needs one round", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = grid_of(18, 14, 0.01016);
    SolveOptions options;
    options.rounds = 1;
    double cold = 0.0, warm = 0.0, settled = 0.0;
    for (int set = 0; set < 10; ++set) {
        std::vector<Focus> foci = random_foci(g, 10);
        const auto drives = solve(array, foci);
        for (Focus& focus : foci) focus.position.x += 0.0002;
        const Quality followed = quality_of(array, foci, solve(array, foci, options, drives));
        REQUIRE(followed.spread <= 0.002);
        warm += followed.efficiency / 10.0;
        cold += quality_of(array, foci, solve(array, foci, options)).efficiency / 10.0;
        settled += quality_of(array, foci, solve(array, foci)).efficiency / 10.0;
    }
    // One round from nothing makes foci even, too, but weaker.
    REQUIRE(warm > cold + 0.01);
    REQUIRE(warm > settled - 0.005);
}

TEST_CASE("compile: steps of several foci take the solver that was asked for, and the manifest tells it", "[solver]") {
    const Array array = find_array("tile-10x10");
    const Core core = find_configuration("tile-100");
    Path path;
    path.steps.push_back({{{from_mm(-25, 0, 130)}, {from_mm(20, 10, 140)}, {from_mm(5, -30, 125)}}, 40});
    path.steps.push_back({{{from_mm(0, 0, 130)}}, 40});
    std::vector<double> spreads;
    for (const MethodName& one : method_names) {
        const Compiled compiled = compile(path, array, core, 0, "image", one.method);
        const Manifest again = manifest_from_json(to_text(compiled.bundle.manifest), "test");
        CAPTURE(one.name);
        REQUIRE(again.solver == one.method);
        const Record& record = compiled.bundle.image.records[0];
        DriveList drives;
        for (std::size_t m = 0; m < array.elements.size(); ++m)
            drives.push_back(std::polar(1.0, -2.0 * std::numbers::pi * record.timings[m] / record.cycle_length));
        std::vector<double> shares = made(array, path.steps[0].foci, drives);
        for (std::size_t k = 0; k < 3; ++k) shares[k] /= most(array, path.steps[0].foci[k].position);
        spreads.push_back(spread(shares));
        // The check of measured pulses compares with the same solver's exact phases.
        for (auto& drive : drives) drive *= array.transducer.source_pa_m;
        REQUIRE(check_record(again, again.records[0], drives).pressure_kept > 0.995);
    }
    REQUIRE(spreads[0] < 0.005);
    REQUIRE(spreads[4] > 0.02);
    path.steps.erase(path.steps.begin());
    const Compiled single = compile(path, array, core, 0, "image", Method::superposition);
    REQUIRE(to_text(single.bundle.manifest).find("solver") == std::string::npos);
    REQUIRE(single.bundle.hex == compile(path, array, core).bundle.hex);
    // A manifest of several foci without a solver is an old one.
    std::string text = to_text(
        compile(Path{{{{{from_mm(-25, 0, 130)}, {from_mm(20, 10, 140)}}, 40}}, {}}, array, core).bundle.manifest);
    const std::string line = " \"solver\": \"gauss-newton\",\n";
    REQUIRE(text.find(line) != std::string::npos);
    REQUIRE_REFUSED(manifest_from_json(std::string(text).replace(text.find("gauss-newton"), 5, "magic"), "test"));
    text.erase(text.find(line), line.size());
    REQUIRE(manifest_from_json(text, "test").solver == Method::superposition);
}

TEST_CASE("solver: says what it cannot do, and with which focus", "[solver]") {
    const Array array = find_array("tile-10x10");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const Focus good{{0.0, 0.0, 0.15}};
    struct Bad {
        std::vector<Focus> foci;
        const char* says;
    };
    std::vector<Focus> many;
    for (int i = 0; i < 101; ++i) many.push_back({{0.001 * i, 0.0, 0.15}});
    const Bad cases[] = {{{}, "none"},
                         {{good, {{0.0, nan, 0.1}}}, "focus 2"},
                         {{good, {{0.01, 0.0, 0.1}, nan}}, "focus 2"},
                         {{good, {{0.01, 0.0, 0.1}, 1.5}}, "amplitude"},
                         {{{array.elements[36].position}, good}, "element"},
                         {{good, {{0.01, 0.0, 0.1}}, good}, "focus 3"},
                         {many, "elements"}};
    FastSolver fast(array, 100);
    for (const Bad& bad : cases) {
        CAPTURE(bad.says);
        for (const MethodName& one : method_names) REQUIRE_REFUSED(solve(array, bad.foci, by(one.method)));
        REQUIRE_REFUSED(quality_of(array, bad.foci, DriveList(100, 1.0)));
        if (bad.says != std::string("elements")) REQUIRE_REFUSED(fast.solve(bad.foci));
    }
    REQUIRE_REFUSED(fast.solve(many));
    REQUIRE_REFUSED(solve(array, std::vector{good}, {}, DriveList(3, 1.0)));
    REQUIRE_REFUSED(quality_of(array, std::vector{good}, DriveList(3, 1.0)));
    REQUIRE_REFUSED(method_of("magic"));
    REQUIRE(method_of("gs-pat") == Method::gs_pat);
    REQUIRE_REFUSED(FastSolver(array, 0));
    REQUIRE_REFUSED(FastSolver(array, 101));
    FastSolver fresh(array, 4);
    REQUIRE_REFUSED(fresh.follow(std::vector{good}));
    std::vector<std::uint16_t> room(7);
    REQUIRE_REFUSED(fresh.ticks(Timer{}, room));
    Array behind = array;
    behind.transducer.pattern = Pattern::table;
    behind.transducer.table = {1.0, 0.5};
    const std::vector<Focus> below{{{0.0, 0.0, -0.1}}};
    REQUIRE_REFUSED(solve(behind, below));
    REQUIRE_REFUSED(FastSolver(behind, 1).solve(below));
}

TEST_CASE("fast solver: as good as the one in double precision, on every instruction set", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const struct {
        Array array;
        std::size_t foci;
    } cases[] = {{grid_of(18, 14, 0.01016), 10}, {grid_of(16, 16, 0.0105), 16}, {grid_of(18, 14, 0.01016), 32},
                 {find_array("tile-10x10"), 1},  {find_array("tile-10x10"), 2}, {find_array("tile-7x8"), 3}};
    for (const auto& [array, count] : cases) {
        const std::vector<Focus> foci = random_foci(g, count);
        const Quality exact = quality_of(array, foci, solve(array, foci));
        on_every_target(fast_solver_target, [&] {
            FastSolver fast(array, count);
            fast.solve(foci);
            const auto drives = fast.drives();
            const Quality quality = quality_of(array, foci, drives);
            CAPTURE(count, array.elements.size(), exact.spread, quality.spread);
            REQUIRE(quality.spread <= exact.spread + 0.002);
            REQUIRE(quality.efficiency == Approx(exact.efficiency).epsilon(0.02));
            for (const std::uint32_t cycle : {16U, 250U, 1250U}) {
                Timer timer;
                timer.cycle_ticks = cycle;
                std::vector<std::uint16_t> ticks(drives.size());
                fast.ticks(timer, ticks);
                for (std::size_t m = 0; m < ticks.size(); ++m) {
                    REQUIRE(ticks[m] < cycle);
                    const double exactly = -std::arg(drives[m]) / (2.0 * std::numbers::pi) * cycle;
                    REQUIRE(std::abs(std::remainder(exactly - ticks[m], cycle)) <= 0.5 + 2e-6 * cycle);
                }
            }
        });
    }
}

TEST_CASE("fast solver: arrays of more elements than one block of waves", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = grid_of(40, 40, 0.005);
    const std::vector<Focus> foci = random_foci(g, 8);
    FastSolver fast(array, 8);
    fast.solve(foci);
    REQUIRE(quality_of(array, foci, fast.drives()).spread <= 0.002);
}

TEST_CASE("fast solver: follows foci over a thousand frames", "[solver]") {
    CAPTURE(Catch::rngSeed());
    Generator g(Catch::rngSeed());
    const Array array = grid_of(18, 14, 0.01016);
    std::vector<Focus> foci = random_foci(g, 10);
    FastSolver fast(array, 10);
    fast.solve(foci);
    std::uniform_real_distribution<double> angle(0.0, 2.0 * std::numbers::pi);
    std::vector<double> heading(foci.size());
    for (double& h : heading) h = angle(g);
    double worst = 0.0, followed = 0.0, begun = 0.0;
    std::vector<double> spreads;
    for (int frame = 0; frame < 1000; ++frame) {
        for (std::size_t k = 0; k < foci.size(); ++k)
            for (int tries = 0; tries < 100; ++tries) {
                const Vec3 to = foci[k].position + 0.0002 * Vec3{std::cos(heading[k]), std::sin(heading[k]), 0.0};
                bool free = std::abs(to.x) < 0.06 && std::abs(to.y) < 0.06;
                for (std::size_t j = 0; j < foci.size(); ++j)
                    free = free && (j == k || distance(foci[j].position, to) >= 0.015);
                if (free) {
                    foci[k].position = to;
                    break;
                }
                heading[k] = angle(g);
            }
        fast.follow(foci);
        const Quality quality = quality_of(array, foci, fast.drives());
        spreads.push_back(quality.spread);
        worst = std::max(worst, quality.spread);
        if (frame < 900) continue;
        followed += quality.efficiency / 100.0;
        begun += quality_of(array, foci, solve(array, foci)).efficiency / 100.0;
    }
    CAPTURE(worst, followed, begun);
    std::nth_element(spreads.begin(), spreads.begin() + 990, spreads.end());
    REQUIRE(spreads[990] <= 0.002);
    REQUIRE(worst <= 0.01);
    REQUIRE(followed >= 0.97 * begun);  // efficiency does not decay
}
