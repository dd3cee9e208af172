// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "../refusal.hpp"
#include "haptogram/acoustics/drive.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/region.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "haptogram/verbs/measure.hpp"

using namespace haptogram;

namespace {

/// Full width at half maximum of |p|² through the focus along x.
double width(const Array& array, Vec3 focus) {
    const auto drives = ideal_drives(array, focus);
    const double half = std::norm(pressure(array, drives, focus)) / 2.0;
    double x = 0.0;
    while (std::norm(pressure(array, drives, focus + Vec3{x, 0, 0})) > half) x += 1e-6;
    return 2.0 * x;
}

/// (1/π)∫ cos(τ − x sin τ) dτ: the Bessel function's integral, independent of any library's series.
double bessel_j1(double x) {
    constexpr int steps = 2000;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double t = std::numbers::pi * (i + 0.5) / steps;
        sum += std::cos(t - x * std::sin(t));
    }
    return sum / steps;
}

}  // namespace

TEST_CASE("field: one source against the numbers of another program", "[acoustics]") {
    // levitate's tests: 40 kHz, c = 343, 6 Pa·m, convention e^{+ikR}; ours is its conjugate.
    const double k = 2.0 * std::numbers::pi * 40e3 / 343.0;
    const Vec3 source{0.01, 0.12, -0.025};
    const Vec3 normal = Vec3{2, 3, 4} * (1.0 / std::sqrt(29.0));
    const auto check = [&](Vec3 point, double radius, std::complex<double> expected) {
        const auto p = std::conj(6.0 * piston_wave({source, normal}, point, k, radius));
        REQUIRE(p.real() == Approx(expected.real()).epsilon(1e-8));
        REQUIRE(p.imag() == Approx(expected.imag()).epsilon(1e-8));
    };
    check({0.1, 0.2, 0.3}, 0.0, {-15.10269228, 8.46147216});
    check({0.1, 0.2, 0.3}, 3e-3, {-13.76846639, 7.71395542});
    check({-0.15, 1.27, 0.001}, 0.0, {-4.76079297, 2.00641887});
    check({-0.15, 1.27, 0.001}, 3e-3, {-2.94292484, 1.24028496});
}

TEST_CASE("field: the piston's directivity against the Bessel integral", "[acoustics]") {
    for (double x = 0.01; x < 12.0; x += 0.37)
        REQUIRE(piston_directivity(x) == Approx(2.0 * bessel_j1(x) / x).margin(1e-9));
    REQUIRE(piston_directivity(0.0) == 1.0);
    REQUIRE(piston_directivity(1e-5) == Approx(1.0));
    REQUIRE(std::abs(piston_directivity(3.8317059702)) < 1e-9);  // the first zero
}

TEST_CASE("field: focal width of the paper's tile", "[acoustics]") {
    Array array = find_array("tile-10x10");
    const Vec3 focus = from_mm(0, 0, 130);
    REQUIRE(width(array, focus) == Approx(10.8e-3).margin(0.06e-3));
    array.transducer.radius_m = 0.0;
    REQUIRE(width(array, focus) == Approx(10.6e-3).margin(0.06e-3));
}

TEST_CASE("field: a point on an element is an error", "[acoustics]") {
    const Array array = find_array("tile-10x10");
    REQUIRE_REFUSED(pressure(array, ideal_drives(array, from_mm(0, 0, 100)), array.elements[3].position));
}

TEST_CASE("field: reciprocity, and the matrix agrees with the sum", "[acoustics]") {
    const Array array = find_array("tile-10x10");
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    REQUIRE(piston_wave({{0.01, 0, 0}}, {0.03, 0.02, 0.1}, k, 0.0) ==
            piston_wave({{0.03, 0.02, 0.1}}, {0.01, 0, 0}, k, 0.0));
    const std::vector<Vec3> points = {from_mm(3, 4, 90), from_mm(-30, 14, 150)};
    const auto drives = ideal_drives(array, points[0]);
    const auto matrix = propagation_matrix(array, points);
    for (std::size_t i = 0; i < 2; ++i) {
        std::complex<double> sum = 0.0;
        for (std::size_t m = 0; m < 100; ++m) sum += matrix[i * 100 + m] * drives[m];
        REQUIRE(std::abs(sum - pressure(array, drives, points[i])) < 1e-9 * std::abs(sum));
    }
}

TEST_CASE("drive: amplitude follows sin(π·duty), phase the middle of the pulse", "[acoustics]") {
    const double period = 25e-6;
    for (const double duty : {0.004, 0.1, 0.25, 0.5, 0.75}) {
        std::vector<DrivePulse> train;
        for (int i = 0; i < 7; ++i) train.push_back({i * period + 3e-6, i * period + 3e-6 + duty * period});
        const auto a = carrier_component(train, 1.0 / period, 7 * period);
        REQUIRE(std::abs(a) == Approx(std::sin(std::numbers::pi * duty)).epsilon(1e-9));
        const double middle = 3e-6 + duty * period / 2.0;
        REQUIRE(std::abs(std::remainder(std::arg(a) + 2.0 * std::numbers::pi * middle / period,
                                        2.0 * std::numbers::pi)) < 1e-9);
    }
    REQUIRE(std::abs(carrier_component({}, 40e3, 1.0)) == 0.0);
}

TEST_CASE("focus check: quantised phases keep what theory says", "[acoustics]") {
    const Array array = find_array("hoshi-18x18");
    const int bits = GENERATE(8, 5, 4, 3);
    const double step = 2.0 * std::numbers::pi / (1 << bits);
    const double kept = std::sin(step / 2.0) / (step / 2.0);  // errors spread evenly over a step: sinc(1/2^bits)
    double mean = 0.0;
    int count = 0;
    for (double x = -50; x <= 50; x += 9.7)
        for (double y = -50; y <= 50; y += 13.3) {
            const Vec3 focus = from_mm(x, y, 150.0 + x / 3.0);
            auto drives = ideal_drives(array, focus);
            for (auto& d : drives) d = std::polar(std::abs(d), std::round(std::arg(d) / step) * step);
            mean += check_focus(array, drives, ideal_drives(array, focus), focus).pressure_kept;
            ++count;
        }
    REQUIRE(mean / count == Approx(kept).margin((1.0 - kept) * 0.05 + 1e-6));
}

TEST_CASE("focus check: a focus that is elsewhere is found to be elsewhere", "[acoustics]") {
    const Array array = find_array("tile-10x10");
    const auto drives = ideal_drives(array, from_mm(1.0, 0, 130));
    const auto ideal = ideal_drives(array, from_mm(0, 0, 130));
    const FocusCheck check = check_focus(array, drives, ideal, from_mm(0, 0, 130));
    REQUIRE(check.peak_offset_m == Approx(1e-3).margin(0.05e-3));
    REQUIRE(check.pressure_kept < 0.995);
    const FocusCheck exact = check_focus(array, ideal, ideal, from_mm(0, 0, 130));
    REQUIRE(exact.pressure_kept == Approx(1.0).epsilon(1e-12));
    REQUIRE(exact.peak_offset_m < 1e-6);
}

TEST_CASE("measure: a record's drives from its pulses, edges of a stretch left out", "[acoustics]") {
    Manifest manifest;
    manifest.array = find_array("tile-10x10");
    manifest.array.elements.resize(2);
    manifest.records = {{{{from_mm(0, 0, 100)}}, 1.0, 5}, {{{from_mm(0, 0, 110)}}, 1.0, 1}};
    std::vector<Pulse> pulses;
    for (std::uint64_t i = 0; i < 5; ++i) {
        pulses.push_back({1250 * i, 1250 * i + 625, 0, 1});
        pulses.push_back({1250 * i + 625, 1250 * i + 1250, 1, 1});
    }
    pulses[0].fall += 300;  // merged with another record's
    const auto records = measure(manifest, pulses, "p");
    REQUIRE(records[0].cycles == 5);
    REQUIRE(std::abs(records[0].drives[0]) == Approx(manifest.array.transducer.source_pa_m));
    REQUIRE(std::abs(records[0].drives[0] + records[0].drives[1]) < 1e-9);  // half a period apart
    REQUIRE(records[1].cycles == 0);
    pulses.push_back({0, 1, 2, 1});
    REQUIRE_REFUSED(measure(manifest, pulses, "p"));
    pulses.back() = {0, 1, 0, 3};
    REQUIRE_REFUSED(measure(manifest, pulses, "p"));
}

TEST_CASE("region: texts that name one, and texts that do not", "[acoustics]") {
    const Reach reach{0.02, 0.01, {}, {}, {}};
    const Region plane = parse_region("plane", "xz@y=-5.5", reach);
    REQUIRE(plane.axes == "xz");
    REQUIRE(plane.grid.size() == 5 * 4);
    REQUIRE(plane.grid.point(3 * 5).x == Approx(-0.02));
    REQUIRE(plane.grid.point(3 * 5).y == Approx(-0.0055));
    REQUIRE(plane.grid.point(3 * 5).z == Approx(0.04));
    REQUIRE(parse_region("plane", "z@y=1,x=2", reach).grid.x == std::vector<double>{0.002});
    REQUIRE(parse_region("plane", "xyz", reach).grid.size() == 5 * 5 * 4);
    Reach ranged = reach;
    ranged.z = parse_range("z", "100:130");
    REQUIRE(parse_region("plane", "z@x=0,y=0", ranged).grid.z.size() == 4);
    REQUIRE(parse_region("plane", "z@x=0,y=0", ranged).grid.z.back() == Approx(0.13));
    for (const char* text : {"", "xy", "xy@z=", "xy@x=1", "zx@y=1", "xy@z=1mm", "xy@z=nan", "xy@z=-1", "xy@z=0",
                             "z@x=1", "@", "@x=1,y=1,z=1", "z@x=1,x=1", "xyz@z=1", "z@x=1,y=1,"})
        REQUIRE_THROWS_AS(parse_region("plane", text, reach), Error);
    for (const char* text : {"", ":", "1:", ":1", "2:1", "1:1", "a:b", "0:inf"})
        REQUIRE_THROWS_AS(parse_range("x", text), Error);
    REQUIRE_THROWS_AS(parse_region("plane", "xy@z=100", {0.02, 0.0, {}, {}, {}}), Error);
    // Errors name the setting, which each front end shows in its own words.
    const auto setting_at_fault = [](const char* text, const Reach& size) -> std::string {
        try {
            (void)parse_region("plane", text, size);
        } catch (const Error& error) {
            REQUIRE(error.code() == ErrorCode::bad_argument);
            REQUIRE(error.names_setting());
            return error.where();
        }
        return "none";
    };
    REQUIRE(setting_at_fault("xy", reach) == "plane");
    REQUIRE(setting_at_fault("xy@z=-1", reach) == "plane");
    REQUIRE(setting_at_fault("xy@z=100", {0.02, 0.03, {}, {}, {}}) == "step");
    REQUIRE(setting_at_fault("xy@z=100", {1.0, 1e-9, {}, {}, {}}) == "step");
    REQUIRE(setting_at_fault("xy@z=100", reach) == "none");
    REQUIRE_REFUSED(parse_region("plane", "xy@z=100", {1.0, 1e-9, {}, {}, {}}));
}

TEST_CASE("region: oblique planes by turns and by a normal", "[acoustics]") {
    const Reach reach{0.02, 0.01, {}, {}, {}};
    const auto near = [](Vec3 a, Vec3 b) { return distance(a, b) < 1e-12; };
    const Region turned = parse_region("plane", "uv@x=1,z=130,rx=30", reach);
    REQUIRE(turned.axes == "uv");
    REQUIRE(turned.grid.size() == 25);
    REQUIRE(near(turned.point(12), {0.001, 0.0, 0.13}));
    REQUIRE(near(turned.point(14), {0.021, 0.0, 0.13}));  // u along x
    REQUIRE(near(turned.point(22), {0.001, 0.02 * std::sqrt(0.75), 0.13 + 0.02 * 0.5}));
    // A normal: v rises by one for each two along y; u stays along x; the length does not matter.
    const Region facing = parse_region("plane", "uv@z=130,ny=-5,nz=10", reach);
    REQUIRE(near(facing.point(14), {0.02, 0.0, 0.13}));
    REQUIRE(near(facing.point(22), {0.0, 0.04 / std::sqrt(5.0), 0.13 + 0.02 / std::sqrt(5.0)}));
    const Region upright = parse_region("plane", "uv@z=130,nx=1", reach);  // as yz@x=0
    REQUIRE(near(upright.point(14), {0.0, 0.02, 0.13}));
    REQUIRE(near(upright.point(22), {0.0, 0.0, 0.15}));
    REQUIRE(parse_region("plane", "uv@z=130", reach).grid.x == parse_region("plane", "xy@z=130", reach).grid.x);
    for (const char* text : {"uv", "uv@z=130,rx=1,nx=1", "uv@z=130,nx=0", "uv@z=130,ry", "uv@z=130,z=1", "uv@q=1,z=9",
                             "uv@rx=30", "uv@z=9,rx=30", "vu@z=130", "uv@z=130,nx=nan"})
        REQUIRE_THROWS_AS(parse_region("plane", text, reach), Error);
    REQUIRE_REFUSED(parse_region("plane", "uv@z=5,rx=30", reach));
}

TEST_CASE("radiation pressure: Hoshi's single transducer and hundred in phase", "[acoustics]") {
    // 24 Pa rms each; a hundred in phase give 83 Pa with α = 2, ρ = 1.2, c = 340.
    Array array = find_array("hoshi-18x18");
    array.elements.assign(1, {{0, 0, 0}});
    const std::vector<std::complex<double>> drives = {100.0 * array.transducer.source_pa_m};
    const WeightedDrives once{1.0, drives};
    const float square = mean_square_pressure(array, {&once, 1}, {{0.0}, {0.0}, {0.3}}).at(0);
    REQUIRE(2.0 * square / (array.medium.density_kg_m3 * array.medium.speed_m_s * array.medium.speed_m_s) ==
            Approx(83.0).margin(0.3));
}
