// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/verbs/probe.hpp"

using namespace haptogram;
using std::numbers::pi;

namespace {

using Complex = std::complex<double>;

Region points_of(std::vector<double> x, double z) { return {{std::move(x), {0.0}, {z}}, "x", "x", {}}; }

DriveSequence sequence_of(const Array& array, const std::vector<Vec3>& foci,
                          const std::vector<std::uint64_t>& periods) {
    DriveSequence sequence;
    for (std::size_t i = 0; i < foci.size(); ++i) {
        sequence.drives.push_back(ideal_drives(array, foci[i]));
        sequence.steps.push_back({i, periods[i], 1});
    }
    return sequence;
}

}  // namespace

TEST_CASE("probe: the receiver's directivity is that of a piston", "[probe]") {
    Array one = find_array("tile-10x10");
    one.elements = {{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}};
    one.transducer.pattern = Pattern::point;
    const double height = 0.5, k = 2.0 * pi / one.wavelength_m();
    const Probe probe = probe_of("haptogram");
    for (const double sine : {0.0, 0.2, 0.5, 0.8}) {
        const double x = height * sine / std::sqrt(1.0 - sine * sine), range = std::hypot(x, height);
        const Field read =
            probe_field(one, sequence_of(one, {{x, 0.0, height}}, {1}), {}, points_of({x}, height), probe);
        const double wave = one.transducer.source_pa_m / range * std::exp(-one.medium.absorption_np_m * range);
        INFO("sine " << sine);
        CHECK(read.parts.at(0).at(0) ==
              Approx(std::abs(piston_directivity(k * 4.5e-3 * sine)) * wave / std::sqrt(2.0)).epsilon(2e-3));
    }
}

TEST_CASE("probe: a tiny one reads the field", "[probe]") {
    const Array array = find_array("tile-10x10");
    const Vec3 focus = from_mm(5, 0, 130);
    const Region line = points_of({-0.02, 0.0, 0.005, 0.01}, 0.13);
    Probe receiver = probe_of("haptogram"), sensor = probe_of("hoshi:100");
    receiver.aperture_m = sensor.aperture_m = 1e-6;
    const DriveSequence steady = sequence_of(array, {focus}, {1});
    const Excitation excitation = excitation_of(array, focus);
    const Field rms = field(excitation, line, Quantity::rms), radiation = field(excitation, line, Quantity::radiation);
    const Field heard = probe_field(array, steady, {}, line, receiver);
    // A square of 100 Hz: 2/π of what it switches, in 400 steps, and the same in every window.
    Modulation square{std::vector<double>(400, 1.0), 1};
    for (std::size_t i = 200; i < 400; ++i) square.samples[i] = 0.0;
    const Field pressed = probe_field(array, steady, square, line, sensor);
    REQUIRE(pressed.names == std::vector<std::string>{"mean", "least", "greatest"});
    for (std::size_t i = 0; i < line.grid.size(); ++i) {
        CHECK(heard.parts[0][i] == Approx(rms.parts[0][i]).epsilon(1e-3));
        for (const std::vector<float>& part : pressed.parts)
            CHECK(part[i] == Approx(2.0 / (400.0 * std::sin(pi / 400.0)) * radiation.parts[0][i]).epsilon(1e-3));
    }
    // Half of the time: the rectified signal's mean is half, its rms would be 0.71.
    CHECK(probe_field(array, steady, square, line, receiver).parts[0][2] == Approx(0.5 * heard.parts[0][2]));
    CHECK(probe_field(array, steady, {}, line, sensor).parts[2][2] < 1e-6 * radiation.parts[0][2]);
}

TEST_CASE("probe: the least and the greatest of the windows of a minute", "[probe]") {
    // A pass of 4,310 periods is not in step with windows of 4,000: each of them has another component of 110 Hz.
    const Array array = find_array("tile-10x10");
    const DriveSequence sequence =
        sequence_of(array, {from_mm(0, 0, 130), from_mm(8, 0, 130), from_mm(-30, 0, 130)}, {1100, 510, 2700});
    const Region line = points_of({0.0, 0.004}, 0.13);
    Probe probe = probe_of("hoshi:110");
    probe.observation_s = 1.0;
    const Field found = probe_field(array, sequence, {}, line, probe);
    for (std::size_t i = 0; i < line.grid.size(); ++i) {
        std::vector<double> pressed;
        for (const auto& drives : sequence.drives) {  // over the face by a midpoint rule of its own
            double sum = 0.0;
            int cells = 0;
            for (int a = -10; a <= 10; ++a)
                for (int b = -10; b <= 10; ++b)
                    if (std::hypot(a, b) <= 10.0) {
                        ++cells;
                        const Vec3 at = line.point(i) + Vec3{a * 1e-4, b * 1e-4, 0.0};
                        sum += radiation_pressure(pressure(array, drives, at), array.medium);
                    }
            pressed.push_back(sum / cells);
        }
        // Eleven periods of 110 Hz are 4,000 carrier periods.
        double least = 1e9, greatest = 0.0, mean = 0.0;
        for (int w = 0; w < 10; ++w) {
            Complex sum;
            for (int n = 0; n < 4000; ++n) {
                const int at = (w * 4000 + n) % 4310;
                sum += std::polar(2.0 / 4000 * pressed[at < 1100 ? 0 : at < 1610 ? 1 : 2], -2.0 * pi * 11 * n / 4000);
            }
            least = std::min(least, std::abs(sum));
            greatest = std::max(greatest, std::abs(sum));
            mean += std::abs(sum) / 10;
        }
        REQUIRE(greatest > 1.2 * least);
        CHECK(found.parts[0][i] == Approx(mean).epsilon(5e-3));
        CHECK(found.parts[1][i] == Approx(least).epsilon(5e-3));
        CHECK(found.parts[2][i] == Approx(greatest).epsilon(5e-3));
    }
}

TEST_CASE("probe: what cannot be read", "[probe]") {
    const Array array = find_array("tile-10x10");
    DriveSequence sequence = sequence_of(array, {from_mm(0, 0, 130)}, {3});
    const Region line = points_of({0.0}, 0.13);
    for (const char* text : {"", "hoshi", "hoshi:", "hoshi:0", "hoshi:-1", "hoshi:1e999", "hoshi:100x", "robot"})
        CHECK_REFUSED(probe_of(text));
    CHECK_REFUSED(probe_field(array, sequence, {}, line, probe_of("hoshi:20001")));
    CHECK_REFUSED(probe_field(array, sequence, {{1.0, 0.0}, 5000011}, line, probe_of("haptogram")));
    sequence.repeats = false;
    CHECK_REFUSED(probe_field(array, sequence, {}, line, probe_of("haptogram")));
}
