// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/perception/felt.hpp"
#include "haptogram/perception/magnitude.hpp"
#include "haptogram/perception/tables.hpp"

using namespace haptogram;
using namespace haptogram::perception;
using Catch::Matchers::Message;
using std::numbers::pi;

namespace {

/// What was computed from the printed tables with numpy's roots, to the digits given.
struct Derived {
    double hz, full_gf, magnitude_there, vertex_gf, zero_gf;
    std::array<double, 3> commands;  ///< for magnitudes of 1, 2 and 3; 0: not reachable
};
constexpr Derived derived[] = {{80, 0.6185, 10.149, 1.115, 0.0090, {0.33468, 0.42594, 0.51003}},
                               {100, 0.5804, 8.928, 0.680, 0.0123, {0.35204, 0.43678, 0.51672}},
                               {140, 0.5587, 8.070, 0.707, -0.0058, {0.33926, 0.44367, 0.53973}},
                               {180, 0.5478, 7.592, 0.838, 0.0051, {0.39805, 0.50983, 0.60865}},
                               {240, 0.5280, 4.363, 0.679, -0.0145, {0.43890, 0.61582, 0.76236}},
                               {300, 0.4926, 2.458, 0.831, -0.0535, {0.56460, 0.85367, 0.0}}};

}  // namespace

TEST_CASE("perception: what follows from Tables I and II, to the digits", "[perception]") {
    const Tables tables = find_tables();
    REQUIRE(tables.fits.size() == std::size(derived));
    for (std::size_t i = 0; i < std::size(derived); ++i) {
        const Derived& expected = derived[i];
        const FrequencyFit fit = fit_at(tables, expected.hz);
        INFO(expected.hz << " Hz");
        REQUIRE(fit.frequency_hz == expected.hz);
        const double full = full_output_gf(fit);
        REQUIRE(full == Approx(expected.full_gf).margin(0.00005));
        REQUIRE(command_of_output(fit, full) == Approx(1.0).margin(1e-12));
        REQUIRE(magnitude_of_output(fit, full) == Approx(expected.magnitude_there).margin(0.0005));
        // Magnitudes rise up to the parabola's vertex, which lies beyond all that the device can do.
        REQUIRE(-fit.magnitude[1] / (2 * fit.magnitude[0]) == Approx(expected.vertex_gf).margin(0.0005));
        REQUIRE(full < expected.vertex_gf);
        // The command rises everywhere: its slope is least at the inflection of the cubic, N − M²/(3L).
        const auto [l, m, n, u] = fit.command;
        const double least_slope = n - m * m / (3 * l);
        REQUIRE(least_slope >= 0.839 - 0.0005);
        REQUIRE(least_slope <= 0.900 + 0.0005);
        // The parabola's zero, with the textbook formula; where it is negative there is a sensation at no output.
        const auto [g, j, v] = fit.magnitude;
        REQUIRE((-j + std::sqrt(j * j - 4 * g * v)) / (2 * g) == Approx(expected.zero_gf).margin(0.00005));
        if (expected.zero_gf > 0) REQUIRE(output_of_magnitude(fit, 0.0) == Approx(expected.zero_gf).margin(0.00005));
        for (int wanted = 1; wanted <= 3; ++wanted) {
            const double command = expected.commands[static_cast<std::size_t>(wanted - 1)];
            if (command == 0.0)
                REQUIRE_REFUSED(output_of_magnitude(fit, wanted));
            else
                REQUIRE(command_of_output(fit, output_of_magnitude(fit, wanted)) == Approx(command).margin(0.000005));
        }
    }
}

TEST_CASE("perception: both inverses undo their polynomials, at any frequency", "[perception]") {
    const Tables tables = find_tables();
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> part(0.0, 1.0);
    for (int i = 0; i < 2000; ++i) {
        const double hz = 80.0 * std::pow(300.0 / 80.0, part(random));
        const FrequencyFit fit = fit_at(tables, hz);
        const double g = part(random) * full_output_gf(fit);
        CAPTURE(hz, g);
        REQUIRE(output_of_command(fit, command_of_output(fit, g)) == Approx(g).margin(1e-12));
        REQUIRE(output_of_magnitude(fit, magnitude_of_output(fit, g)) == Approx(g).margin(1e-12));
    }
    // Half way between 100 and 140 Hz on a logarithmic scale the values are means.
    const double middle = std::sqrt(100.0 * 140.0);
    const FrequencyFit fit = fit_at(tables, middle), a = fit_at(tables, 100), b = fit_at(tables, 140);
    for (const double g : {0.0, 0.1, 0.5}) {
        REQUIRE(command_of_output(fit, g) == Approx((command_of_output(a, g) + command_of_output(b, g)) / 2));
        REQUIRE(magnitude_of_output(fit, g) == Approx((magnitude_of_output(a, g) + magnitude_of_output(b, g)) / 2));
    }
}

TEST_CASE("perception: nothing is extrapolated", "[perception]") {
    const Tables tables = find_tables();
    const FrequencyFit fit = fit_at(tables, 180);
    REQUIRE_REFUSED(fit_at(tables, 79.9));
    REQUIRE_REFUSED(fit_at(tables, NAN));
    REQUIRE_REFUSED(command_of_output(fit, 0.5479));
    REQUIRE_REFUSED(magnitude_of_output(fit, -0.001));
    REQUIRE_REFUSED(output_of_command(fit, 0.258));
    REQUIRE_REFUSED(output_of_command(fit, 1.001));
    REQUIRE_REFUSED(output_of_magnitude(fit, 7.6));
    REQUIRE_REFUSED(threshold_interval(tables, Region::palm, 0.5));
    REQUIRE_REFUSED(threshold_interval(tables, Region::palm, 10.1));
    REQUIRE_REFUSED(region_of("elbow"));
}

TEST_CASE("perception: thresholds of Table III by region, grip force and frequency", "[perception]") {
    const Tables tables = find_tables();
    for (const ThresholdRow& row : tables.thresholds) {
        REQUIRE(threshold_interval(tables, Region::palm, row.grip_n).low_gf == Approx(row.palm.low_gf));
        REQUIRE(threshold_interval(tables, Region::finger, row.grip_n).high_gf == Approx(row.finger.high_gf));
    }
    const Interval middle = threshold_interval(tables, Region::finger, std::sqrt(3.0));
    REQUIRE(middle.low_gf == Approx((0.06568 + 0.08252) / 2));
    REQUIRE(middle.high_gf == Approx((0.09169 + 0.1005) / 2));
    for (const double hz : {180.0, 200.0, 240.0})
        REQUIRE(least_felt_gf(tables, Region::palm, hz, 3) == Approx(0.06794));
    for (const double hz : {80.0, 300.0}) REQUIRE(least_felt_gf(tables, Region::palm, hz, 3) == Approx(0.08392));
    REQUIRE(least_felt_gf(tables, Region::palm, std::sqrt(80.0 * 180.0), 3) == Approx((0.06794 + 0.08392) / 2));
    // Lines of least squares, from numpy's polyfit over ln F.
    const ThresholdLaw finger = threshold_law(tables, Region::finger), palm = threshold_law(tables, Region::palm);
    REQUIRE(finger.a_gf == Approx(0.07721).margin(0.000005));
    REQUIRE(finger.b_gf == Approx(0.01353).margin(0.000005));
    REQUIRE(finger.largest_residual_gf == Approx(0.0053).margin(0.00005));
    REQUIRE(palm.a_gf == Approx(0.06257).margin(0.000005));
    REQUIRE(palm.b_gf == Approx(0.01409).margin(0.000005));
    REQUIRE(palm.largest_residual_gf == Approx(0.0022).margin(0.00005));
    REQUIRE(threshold_interval(tables, Region::palm, 1).centre_gf() * gram_force_n * 1e3 == Approx(0.63).margin(0.005));
    REQUIRE(threshold_interval(tables, Region::finger, 1).centre_gf() * gram_force_n * 1e3 ==
            Approx(0.77).margin(0.005));
    // Displacement: 0.16 µm at 200 Hz; four octaves of 12 dB would be 48, so 12 dB between 125 and 250 Hz.
    REQUIRE(least_displacement_db(200) == Approx(-16.1).margin(0.05));
    REQUIRE(std::pow(10.0, least_displacement_db(200) / 20.0) == Approx(0.16).margin(0.005));
    REQUIRE(least_displacement_db(125) - least_displacement_db(250) == Approx(12.04).margin(0.01));
    REQUIRE(least_displacement_db(20) == 12.5);
    REQUIRE(least_displacement_db(1000) - least_displacement_db(500) == Approx(12.04).margin(0.01));
    REQUIRE(least_displacement_db(200, 2.0) == Approx(-16.1 - 3.0).margin(0.06));
    REQUIRE_THROWS_AS(least_displacement_db(1001), Error);
    REQUIRE_THROWS_AS(least_displacement_db(200, 0.0), Error);
}

TEST_CASE("perception: means and fundamentals of waveforms beside sums over many samples", "[perception]") {
    constexpr int samples = 200000;
    const auto direct = [](Waveform waveform, double duty) {
        double mean = 0.0;
        std::complex<double> fundamental = 0.0;
        for (int i = 0; i < samples; ++i) {
            const double t = (i + 0.5) / samples, m = envelope(waveform, t, duty);
            mean += m * m / samples;
            fundamental += m * m * std::polar(2.0 / samples, -2.0 * pi * t);
        }
        return std::pair(mean, std::abs(fundamental));
    };
    for (const Waveform waveform : all_waveforms()) {
        INFO(name_of(waveform));
        const auto [mean, fundamental] = direct(waveform, 0.5);
        REQUIRE(mean_output(waveform) == Approx(mean).margin(1e-6));
        REQUIRE(fundamental_output(waveform) == Approx(fundamental).margin(1e-6));
        REQUIRE(waveform_of(name_of(waveform)) == waveform);
        REQUIRE(waveform_factor(waveform, Weighing::mean) == Approx(mean / 0.5).margin(1e-5));
    }
    for (const double duty : {0.1, 0.3, 0.5, 0.8, 0.9}) {
        const auto [mean, fundamental] = direct(Waveform::square, duty);
        REQUIRE(mean_output(Waveform::square, duty) == Approx(mean).margin(1e-5));
        REQUIRE(fundamental_output(Waveform::square, duty) == Approx(fundamental).margin(1e-5));
    }
    REQUIRE(fundamental_output(Waveform::square, 0.1) == Approx(0.197).margin(0.0005));
    REQUIRE(waveform_factor(Waveform::sine, Weighing::fundamental) == Approx(0.785).margin(0.0005));
    REQUIRE(waveform_factor(Waveform::triangle, Weighing::fundamental) == Approx(0.637).margin(0.0005));
    REQUIRE(waveform_factor(Waveform::sawtooth, Weighing::fundamental) == Approx(0.525).margin(0.0005));
    REQUIRE(duty_factor(0.5, Weighing::mean) == 1.0);
    REQUIRE(duty_factor(0.25, Weighing::mean) == Approx(2.0));
    REQUIRE(duty_factor(0.25, Weighing::fundamental) == Approx(std::numbers::sqrt2));
    REQUIRE(radiation_linear(0.25) == 0.5);
    REQUIRE_THROWS_AS(radiation_linear(1.1), Error);
    REQUIRE_THROWS_AS(duty_factor(0.0, Weighing::mean), Error);
    REQUIRE_THROWS_AS(duty_factor(1.0, Weighing::fundamental), Error);
    REQUIRE_REFUSED(waveform_of("noise"));
}

TEST_CASE("perception: from a magnitude to a pulse", "[perception]") {
    const Tables tables = find_tables();
    Wanted wanted;
    wanted.frequency_hz = 180;
    wanted.magnitude = 2;
    const Setting plain = setting_for(tables, wanted);
    REQUIRE(plain.command == Approx(0.50983).margin(0.000005));
    REQUIRE(plain.factor == 1.0);
    REQUIRE(std::sin(pi * plain.pulse_duty) == Approx(plain.command));  // the carrier's amplitude over that at 50 %
    REQUIRE(plain.pulse_duty < 0.5);
    // A quarter of the time on: the mean needs twice the output, the fundamental √2.
    wanted.duty = 0.25;
    REQUIRE(setting_for(tables, wanted).needed_gf == Approx(plain.needed_gf * std::numbers::sqrt2));
    wanted.weighing = Weighing::mean;
    REQUIRE(setting_for(tables, wanted).needed_gf == Approx(plain.needed_gf * 2.0));
    // A triangle needs 1/0.637.
    wanted = {2.0, 180.0, Region::palm, 1.0, Waveform::triangle, 0.5, Weighing::fundamental};
    REQUIRE(setting_for(tables, wanted).needed_gf == Approx(plain.needed_gf * pi / 2.0));
    wanted.duty = 0.25;
    REQUIRE_REFUSED(setting_for(tables, wanted));
    wanted = {7.5, 180.0, Region::palm, 1.0, Waveform::triangle, 0.5, Weighing::fundamental};
    REQUIRE_REFUSED(setting_for(tables, wanted));
    wanted = {0.5, 180.0, Region::palm, 1.0, Waveform::square, 0.5, Weighing::fundamental};
    REQUIRE_REFUSED(setting_for(tables, wanted));
    wanted = {2.0, 180.0, Region::finger, 1.0, Waveform::square, 0.5, Weighing::fundamental};
    REQUIRE_REFUSED(setting_for(tables, wanted));
    REQUIRE(pulse_duty(1.0) == 0.5);
    REQUIRE(pulse_duty(0.0) == 0.0);
    REQUIRE_THROWS_AS(pulse_duty(1.01), Error);
}

TEST_CASE("perception: commands are of the force that analyze and feel tell", "[perception]") {
    Array array = find_array("hoshi-18x18");
    const Vec3 focus = from_mm(10, 0, 200);
    const double force = full_force(array, focus);
    REQUIRE(force == steady_force(array, ideal_drives(array, focus), focus));
    REQUIRE(position_factor(array, from_mm(0, 0, 200)) == 1.0);
    REQUIRE(position_factor(array, from_mm(0, 0, 300)) > 1.0);
    REQUIRE(position_factor(array, from_mm(0, 0, 300)) ==
            Approx(full_force(array, from_mm(0, 0, 200)) / full_force(array, from_mm(0, 0, 300))));
    REQUIRE_THROWS_AS(full_force(array, from_mm(1000, 0, 10)), Error);
    // A command is an amplitude: the force of the drives scaled by it is what was needed.
    Wanted wanted;
    const Tables tables = find_tables();
    const Setting setting = setting_for(tables, wanted, array, focus);
    REQUIRE(setting.full_gf == Approx(0.5 * force / gram_force_n));
    REQUIRE(setting.command * setting.command * setting.full_gf == Approx(setting.needed_gf));
    REQUIRE(std::sin(pi * setting.pulse_duty) / std::sin(pi * array.duty) == Approx(setting.command));
    array.transducer.source_pa_m /= 10.0;
    REQUIRE_REFUSED(setting_for(tables, wanted, array, focus));
}

TEST_CASE("perception: a file that cannot be used names its line", "[perception]") {
    const TemporaryFolder folder;
    const std::string good = read_file("shipped:perception/multimodal.toml");
    const std::string path = (folder.path() / "own.toml").string();
    const auto refused = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        const auto at = text.find(from);
        REQUIRE(at != std::string::npos);
        write_file(path, text.replace(at, from.size(), to));
        return heard::refusal_of([&] { (void)load_tables(path); });
    };
    write_file(path, good);
    REQUIRE(find_tables(path).fits.size() == 6);
    REQUIRE_REFUSAL(refused("hz = 80", "hz = 120"));
    REQUIRE_REFUSAL(refused("2.411", "-2.411"));
    REQUIRE_REFUSAL(refused("magnitude = [-10.39", "magnitude = [-30.39"));
    REQUIRE_REFUSAL(refused("palm = [0.05903", "palm = [0.5903"));
    REQUIRE_REFUSAL(refused("grip_n = 1\n", "grip = 1\n"));
    REQUIRE_REFUSAL(refused("haptogram-perception-1", "haptogram-2"));
    REQUIRE_REFUSED(find_tables("none"));
}

TEST_CASE("perception: a path whose foci feel with one magnitude", "[perception]") {
    const Tables tables = find_tables();
    const Array array = find_array("tile-10x10");
    const Wanted wanted = wanted_of(1.5, "square:180", false);
    const std::vector<Vec3> places = {{0.0, 0.0, 0.15}, {0.02, -0.01, 0.12}};
    Path path;
    for (const Vec3& place : {places[0], places[1], places[0]}) path.steps.push_back({{{place, 0.5}}, 10});
    path.steps.push_back({{}, 3});  // silence
    const PathMagnitude made = give_magnitude(path, tables, wanted, array);
    REQUIRE(made.moves);
    REQUIRE(path.steps[0] == path.steps[2]);
    REQUIRE(path.steps[3].foci.empty());
    // The force on the disc, summed over a square lattice: what a square wave leaves of it is the asked output.
    const double output = output_of_magnitude(fit_at(tables, 180.0), 1.5);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Focus& focus = path.steps[i].foci.front();
        const auto drives = ideal_drives(array, focus.position);
        constexpr double step = 0.0004, radius = 0.01;
        double force = 0.0;
        for (double x = -radius + step / 2; x < radius; x += step)
            for (double y = -radius + step / 2; y < radius; y += step)
                if (x * x + y * y < radius * radius) {
                    const auto waves = waves_at_patch(array, focus.position + Vec3{x, y, 0.0}, {0, 0, -1});
                    force += step * step * radiation_pressure(sound_at_patch(waves, drives), array.medium);
                }
        const double command = focus.amplitude / 0.5;  // half was asked of it already
        REQUIRE(0.5 * force * command * command / gram_force_n == Approx(output).epsilon(0.01));
        REQUIRE(command >= made.least_command);
        REQUIRE(command <= made.most_command);
    }

    REQUIRE(wanted_of(2.0, "square:120:0.25", false).duty == 0.25);
    REQUIRE(wanted_of(2.0, "abs-sine:200", false).waveform == Waveform::abs_sine);
    for (const char* am : {"", "static", "sine:200+sine:100", "wav:a.wav"}) REQUIRE_REFUSED(wanted_of(2.0, am, false));
    for (const char* am : {"square:", "square:200:0.5:1", "sine:x", "cosine:200"})
        REQUIRE_REFUSED(wanted_of(2.0, am, false));
    REQUIRE_REFUSED(wanted_of(2.0, "sine:200", true));
    Path two;
    two.steps.push_back({{{places[0], 1.0}, {places[1], 1.0}}, 1});
    REQUIRE_REFUSED(give_magnitude(two, tables, wanted, array));
    Path weak;
    weak.steps.push_back({{{{0.0, 0.0, 0.5}, 1.0}}, 1});
    REQUIRE_REFUSED(give_magnitude(weak, tables, wanted_of(7.0, "square:180", false), array));
}

TEST_CASE("perception: commands from a lattice are those of the places", "[perception]") {
    const Tables tables = find_tables();
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> aside(-0.04, 0.04), above(0.1, 0.2);
    for (const char* name : {"tile-10x10", "hoshi-18x18"}) {
        const Array array = find_array(name);
        const Wanted wanted = wanted_of(1.1, "square:200", false);
        CommandLattice commands(tables, wanted, array);
        double worst = 0.0;
        for (int i = 0; i < 40; ++i) {
            const Vec3 place{aside(random), aside(random), above(random)};
            const double exact = setting_for(tables, wanted, array, place).command;
            worst = std::max(worst, std::abs(commands.at(place) / exact - 1.0));
        }
        INFO(name << ": worst " << worst);
        CHECK(worst < 0.002);
        // A place among known corners needs none of its own.
        static_cast<void>(commands.at({0.001, 0.002, 0.151}));
        const std::size_t known = commands.corners();
        static_cast<void>(commands.at({0.004, 0.001, 0.154}));
        CHECK(commands.corners() == known);
    }
    const Array tile = find_array("tile-10x10");
    // Where the array is just too weak, the lattice is not asked: the place itself decides.
    const double most =
        magnitude_of_output(fit_at(tables, 180.0), 0.5 * full_force(tile, {0.0, 0.0, 0.2013}) / gram_force_n);
    CommandLattice barely(tables, wanted_of(0.9999 * most, "square:180", false), tile);
    CHECK(barely.at({0.0, 0.0, 0.2013}) == Approx(1.0).epsilon(1e-3));
    CommandLattice beyond(tables, wanted_of(1.0001 * most, "square:180", false), tile);
    REQUIRE_REFUSED(beyond.at({0.0, 0.0, 0.2013}));
    REQUIRE_REFUSED(barely.at({0.9, 0.0, 0.01}));
    REQUIRE_REFUSED(CommandLattice(tables, wanted_of(0.1, "square:180", false), tile));
    // A path that is given in pieces gets what it would get as a whole.
    Path path;
    for (const double x : {0.0, 0.013, -0.02}) path.steps.push_back({{{{x, 0.01, 0.15}, 0.5}}, 10});
    Path whole = path;
    const Wanted wanted = wanted_of(1.5, "square:180", false);
    CommandLattice commands(tables, wanted, tile);
    const PathMagnitude by_lattice = give_magnitude(path, commands),
                        exact = give_magnitude(whole, tables, wanted, tile);
    for (std::size_t i = 0; i < path.steps.size(); ++i)
        CHECK(path.steps[i].foci[0].amplitude == Approx(whole.steps[i].foci[0].amplitude).epsilon(0.002));
    CHECK(by_lattice.most_command == Approx(exact.most_command).epsilon(0.002));
    CHECK(by_lattice.moves);
}

TEST_CASE("perception: steps that could be told apart, in the range where they were measured", "[perception]") {
    CHECK(strength_steps(-3.0) == std::array<unsigned, 2>{0, 0});
    CHECK(strength_steps(1.64) == std::array<unsigned, 2>{0, 0});
    CHECK(strength_steps(2.98) == std::array<unsigned, 2>{1, 1});
    CHECK(strength_steps(20.0) == std::array<unsigned, 2>{6, 12});
    CHECK(strength_steps(35.0) == std::array<unsigned, 2>{11, 21});
    const auto next = next_frequency_hz(200.0);
    REQUIRE(next.has_value());
    CHECK(next->at(0) == Approx(226.0));
    CHECK(next->at(1) == Approx(276.0));
    CHECK(next_frequency_hz(2.0).has_value());
    CHECK(next_frequency_hz(300.0).has_value());
    CHECK_FALSE(next_frequency_hz(1.9).has_value());
    CHECK_FALSE(next_frequency_hz(300.1).has_value());
    CHECK_FALSE(next_frequency_hz(std::nan("")).has_value());
}
