// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/transient.hpp"
#include "haptogram/array/calibration.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/calibration/code.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/solve/even.hpp"
#include "haptogram/solve/fast_solver.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "haptogram/solve/solver.hpp"

using namespace haptogram;
using Complex = std::complex<double>;
using std::numbers::pi;

namespace {

const Vec3 focus{0.012, -0.02, 0.14};

/// The tile with elements as they are bought, two of them dead.
Array bought(unsigned seed = 3) {
    Array array = find_array("tile-10x10");
    std::mt19937 random(seed);
    std::normal_distribution<double> gain(1.0, 0.12), phase(0.0, 0.25);
    for (Element& element : array.elements)
        element.response = std::polar(gain(random), phase(random) + (random() % 10 == 0 ? pi : 0.0));
    array.elements[17].response = array.elements[60].response = 0.0;
    return array;
}

/// What the elements make together at a point when all their waves are in phase there: 1 Pa·m each.
double in_phase(const Array& array, Vec3 point) {
    double sum = 0.0;
    for (const Element& element : array.elements) sum += std::abs(propagation(array, element, point));
    return sum;
}

struct Written {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("haptogram_calibration_" + std::to_string(getpid()) + ".toml");
    explicit Written(const std::string& text) { write_file(path, text); }
    Written(const Written&) = delete;
    Written& operator=(const Written&) = delete;
    ~Written() { std::filesystem::remove(path); }
};

}  // namespace

TEST_CASE("a calibration file is read as it is written, and puts each element on its channel") {
    Calibration made;
    made.array = "tile-7x8";
    made.date = "2026-11-25";
    made.temperature_c = 21.5;
    made.residual = 0.034;
    made.elements.resize(56);
    for (std::uint32_t m = 0; m < 56; ++m) made.elements[m].channel = m;
    made.elements[3] = {1.2, 0.5, true, false, 4, {}, {}};
    made.elements[4] = {0.8, -0.25, false, false, 3, 0.02, 0.125};
    made.elements[9].dead = true;
    made.drive = Drive::equalised;
    const Written file(to_text(made));
    const Calibration read = load_calibration(file.path);
    CHECK(read.array == made.array);
    CHECK(read.date == made.date);
    CHECK(read.temperature_c == made.temperature_c);
    CHECK(read.residual == made.residual);
    CHECK(read.drive == made.drive);
    CHECK(read.elements[4].gain_error == Approx(0.02));
    CHECK(read.elements[4].phase_error_rad.value() == Approx(0.125).margin(1e-4));
    const Array plain = find_array("tile-7x8"), array = find_array(file.path.string());
    CHECK(array.elements[4].position == plain.elements[3].position);
    CHECK(array.elements[3].position == plain.elements[4].position);
    CHECK(std::abs(array.elements[4].response - std::polar(1.2, 0.5 + pi)) < 1e-3);
    CHECK(std::abs(array.elements[3].response - std::polar(0.8, -0.25)) < 1e-3);
    CHECK(array.elements[9].response == 0.0);
    CHECK(array.elements[20].response == 1.0);
    CHECK(array.transducer == plain.transducer);
    CHECK(core_of_array(file.path.string()) == core_of_array("tile-7x8"));
    CHECK(joined(Rig{"two", {{array, {}}, {array, {{0.3, 0.0, 0.0}}}}, {}}).elements[59].response ==
          array.elements[3].response);
}

TEST_CASE("a calibration file that cannot be is refused by name and line") {
    const auto refused = [](const std::string& elements, const std::string& head = "") {
        const Written file("format = \"haptogram-calibration-1\"\narray = \"./one.toml\"\n" + head + "element = [\n" +
                           elements + "]\n");
        write_file(file.path.parent_path() / "one.toml", "[array]\nrows = 1\ncolumns = 2\npitch_mm = 10\n");
        const heard::Refusal found = heard::refusal_of([&] { (void)find_array(file.path.string()); });
        std::filesystem::remove(file.path.parent_path() / "one.toml");
        return found;
    };
    CHECK(refused("{}, {}\n").identity == "no error");
    CHECK_REFUSAL(refused("{}\n"));
    CHECK_REFUSAL(refused("{}, { channel = 0 }\n"));
    CHECK_REFUSAL(refused("{}, { channel = 2 }\n"));
    CHECK_REFUSAL(refused("{},\n{ gain = 0 }\n"));
    CHECK_REFUSAL(refused("{}, { dead = true, gain = 1 }\n"));
    CHECK_REFUSAL(refused("{}, { phase = 1 }\n"));
    CHECK_REFUSAL(refused("{}, {}\n", "source_pa_m = 2\n"));
}

TEST_CASE("every way to a focus uses the elements as they are") {
    const Array array = bought();
    const double best = in_phase(array, focus);
    const auto share = [&](std::span<const Complex> drives) {
        for (const std::size_t dead : {17U, 60U}) CHECK(drives[dead] == 0.0);
        return std::abs(pressure(array, drives, focus)) / best;
    };
    auto ideal = ideal_drives(array, focus);
    for (Complex& drive : ideal) drive /= array.transducer.source_pa_m;
    CHECK(share(ideal) == Approx(1.0).epsilon(1e-9));
    const Focus one{focus};
    for (const Method method : {Method::superposition, Method::distance_weighted, Method::gs, Method::weighted_gs,
                                Method::gs_pat, Method::gauss_newton}) {
        SolveOptions options;
        options.method = method;
        CHECK(share(solve(array, {&one, 1}, options)) == Approx(1.0).epsilon(1e-6));
    }
    const Timer timer = choose_timer(array, find_configuration("tile-100"));
    FastSolver fast(array, 1);
    fast.solve({&one, 1});
    std::vector<std::uint16_t> fast_ticks(100);
    fast.ticks(timer, fast_ticks);
    for (const std::vector<std::uint16_t>& ticks : {focal_law(array, timer, {&focus, 1}), fast_ticks}) {
        std::vector<Complex> drives;
        for (const std::uint16_t tick : ticks)
            drives.push_back(tick == interface::silent_timing ? Complex(0.0)
                                                              : std::polar(1.0, -2.0 * pi * tick / timer.cycle_ticks));
        CHECK(share(drives) > 0.9998);
    }
    // Without them a focus is that of the prototype's arrays.
    Array plain = array;
    for (Element& element : plain.elements) element.response = 1.0;
    auto blind = ideal_drives(plain, focus);
    CHECK(std::abs(pressure(array, blind, focus)) / plain.transducer.source_pa_m / best < 0.9);
}

TEST_CASE("several foci are as strong as they can be with the elements as they are") {
    const Array array = bought();
    const std::vector<Focus> foci{{{0.02, 0.0, 0.15}}, {{-0.02, 0.01, 0.14}}};
    const Quality quality = quality_of(array, foci, solve(array, foci), Level::reachable);
    CHECK(quality.spread < 0.01);
    CHECK(quality.efficiency > 0.9);
    const std::vector<Vec3> points{foci[0].position, foci[1].position};
    const CrossTalk cross_talk(array, points);
    const std::vector<double> half{0.5, 0.5};
    const auto p = [&](std::size_t of, std::size_t at) {
        return std::norm(pressure(array, ideal_drives(array, points[of]), points[at]));
    };
    CHECK(cross_talk.felt(half)[0] == Approx(0.5 * (p(0, 0) + p(1, 0))).epsilon(1e-4));
}

TEST_CASE("a board that computes foci takes the phases from its geometry") {
    const Array array = bought();
    const FocusWords words = pack_focus({focus});
    const auto made = engine_drives(focus_engine(array), {&words, 1}, true);
    std::vector<Complex> drives;
    for (std::size_t m = 0; m < 100; ++m)
        drives.push_back(std::polar(static_cast<double>(made[m].amplitude), -2.0 * pi * made[m].phase / 65536.0));
    CHECK(std::abs(pressure(array, drives, focus)) / (std::abs(drives[0]) * in_phase(array, focus)) > 0.9999);
}

TEST_CASE("a board that computes foci drives no dead element, and the others as the calibration asks") {
    Calibration calibration;
    calibration.array = "tile-7x8";
    for (std::uint32_t m = 0; m < 56; ++m) {
        calibration.elements.emplace_back();
        calibration.elements[m].channel = m;
        calibration.elements[m].gain = 0.8 + 0.01 * (m % 41);
        calibration.elements[m].dead = m == 3 || m == 50;
    }
    const FocusWords words = pack_focus({focus});
    const auto made = [&](Drive drive, bool whole) {
        calibration.drive = drive;
        const Written file(to_text(calibration));
        return engine_drives(focus_engine(find_array(file.path.string())), {&words, 1}, whole);
    };
    const auto full = made(Drive::full, true), weighed = made(Drive::weighed, true),
               even = made(Drive::equalised, true);
    double power = 0.0, force = 0.0;
    for (std::size_t m = 0; m < 56; ++m) {
        const MeasuredElement& one = calibration.elements[m];
        CHECK((full[m].amplitude == 0) == one.dead);
        if (one.dead) {
            CHECK(weighed[m].amplitude + even[m].amplitude == 0);
            continue;
        }
        CHECK(full[m].amplitude == 65535);
        CHECK(weighed[m].amplitude / 65535.0 == Approx(one.gain / 1.2).margin(0.004));
        CHECK(even[m].amplitude / 65535.0 * one.gain == Approx(0.8).margin(0.005));
        power += std::pow(weighed[m].amplitude / 65535.0, 2.0);
        force += weighed[m].amplitude / 65535.0 * one.gain;
    }
    CHECK(made(Drive::equalised, false)[5].amplitude / 65535.0 ==
          Approx(0.8 / calibration.elements[5].gain).margin(0.004));
    // More pressure for its power than any other drive, by Cauchy and Schwarz.
    double squares = 0.0;
    for (const MeasuredElement& one : calibration.elements) squares += one.dead ? 0.0 : one.gain * one.gain;
    CHECK(force * force / power == Approx(squares).epsilon(1e-4));
}

TEST_CASE("records of timings cannot have weights, and say so") {
    Calibration calibration;
    calibration.array = "tile-7x8";
    calibration.elements.resize(56);
    for (std::uint32_t m = 0; m < 56; ++m) calibration.elements[m].channel = m;
    calibration.elements[5].gain = 0.9;
    calibration.drive = Drive::weighed;
    const Written file(to_text(calibration));
    const Array array = find_array(file.path.string());
    CHECK(array.elements[5].weight == Approx(0.9));
    const Timer timer = choose_timer(array, Core{});
    CHECK_REFUSED(focal_law(array, timer, {&focus, 1}));
    FastSolver fast(array, 1);
    std::vector<std::uint16_t> ticks(56);
    CHECK_REFUSED(fast.ticks(timer, ticks));
}

TEST_CASE("fields are those of the elements as they are") {
    const Array array = bought();
    const auto drives = ideal_drives(find_array("tile-10x10"), focus);
    Grid grid;
    for (int i = -20; i <= 20; ++i) {
        grid.x.push_back(i * 1e-3);
        grid.y.push_back(i * 1e-3);
    }
    grid.z = {0.14, 0.15};
    const double most = array.transducer.source_pa_m * in_phase(array, focus);
    const auto near = [&](std::span<const std::complex<float>> values) {
        double off = 0.0;
        for (std::size_t i = 0; i < grid.size(); i += 37)
            off = std::max(off, std::abs(Complex(values[i]) - pressure(array, drives, grid.point(i))));
        return off / most;
    };
    for (const double interpolation : {0.0, 1e-3}) {
        FieldOptions options;
        options.interpolation_error = interpolation;
        CHECK(near(pressure_field(array, drives, grid, options).values) < 1.1e-3 * (interpolation > 0.0 ? 1.0 : 0.1));
    }
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < grid.size(); ++i) points.push_back(grid.point(i));
    CHECK(near(pressure_at(array, drives, points)) < 1e-4);
    const WeightedDrives alone{1.0, drives};
    CHECK(mean_square_pressure(array, {&alone, 1}, grid)[820] ==
          Approx(std::norm(pressure(array, drives, grid.point(820))) / 2.0).epsilon(1e-3));
    constexpr double step = 1e-7;
    const Complex slope = (pressure(array, drives, focus + Vec3{step, 0, 0}) - pressure(array, drives, focus)) / step;
    CHECK(std::abs(pressure_gradient(array, drives, focus).x - slope) < 1e-3 * std::abs(slope));
    const Complex quick = pressure_gradient_at(array, drives, {&focus, 1})[0].x;
    CHECK(std::abs(quick - slope) < 1e-2 * std::abs(slope));
}

TEST_CASE("a sound that settles is that of the elements as they are") {
    const Array array = bought();
    const Resonator resonator = second_order(array);
    const auto trains = focal_trains(array, focus, 0, 120);
    const double step_s = 1.0 / array.carrier_hz / 20.0;
    const auto sound = pressure_over_time(array, resonator, trains, focus, {90.0 / array.carrier_hz, step_s, 200});
    const auto found = envelope(sound, 20);
    CHECK(std::abs(found[100]) == Approx(array.transducer.source_pa_m * in_phase(array, focus)).epsilon(0.01));
}

TEST_CASE("the code's columns are each element's sound alone, and no shift of the code is like it") {
    for (const std::size_t elements : {16U, 100U, 249U, 256U}) {
        const CalibrationCode code(elements);
        REQUIRE(code.patterns() >= elements + 8);
        std::mt19937 random(5);
        std::normal_distribution<double> normal;
        std::vector<Complex> alone, heard(code.patterns());
        for (std::size_t j = 0; j < elements; ++j) alone.emplace_back(normal(random), normal(random));
        for (std::size_t i = 0; i < code.patterns(); ++i)
            for (std::size_t j = 0; j < elements; ++j) heard[i] += code.turned(i, j) ? -alone[j] : alone[j];
        const auto found = code.columns(heard);
        double off = 0.0, all = 0.0, silent = 0.0;
        for (std::size_t j = 0; j < code.patterns(); ++j) {
            off += std::norm(found[j] - (j < elements ? alone[j] : 0.0));
            all += j < elements ? std::norm(alone[j]) : 0.0;
        }
        CHECK(off < 1e-20 * all);
        double least = 1.0;
        for (std::size_t shift = 1; shift < code.patterns(); ++shift) {
            std::rotate(heard.begin(), heard.begin() + 1, heard.end());
            const auto shifted = code.columns(heard);
            silent = 0.0;
            for (std::size_t j = elements; j < code.patterns(); ++j) silent += std::norm(shifted[j]);
            least = std::min(least, silent / all);
        }
        const auto share = static_cast<double>(code.patterns() - elements) / static_cast<double>(code.patterns());
        INFO(least / share);
        CHECK(least > 0.4 * share);
    }
}
