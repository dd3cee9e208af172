// SPDX-License-Identifier: Apache-2.0
// The numbers of Hoshi et al. 2010 and of its device. Fields that are summed here are summed from positions alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/drive.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/transient.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/hand/movement.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/position_table.hpp"
#include "haptogram/solve/segments.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "haptogram/verbs/measure.hpp"

using namespace haptogram;

namespace {

using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;
constexpr double wavelength = 340.0 / 40e3;

/// The fundamental of the radiation pressure, the square of the envelope, when the carrier is switched on and off
/// f times a second: by the library's resonator, sampled four times a carrier period, over one settled period of f.
double fundamental(double bandwidth_hz, double f) {
    constexpr std::size_t samples = 4;
    const auto half = static_cast<std::size_t>(std::lround(40e3 / f / 2.0));  // carrier periods
    const std::size_t settle = (200 / (2 * half) + 2) * 2 * half;
    std::vector<DrivePulse> pulses;
    for (std::size_t i = 0; i < settle + 3 * half; ++i)
        if (i / half % 2 == 0) pulses.push_back({static_cast<double>(i) / 40e3, (static_cast<double>(i) + 0.5) / 40e3});
    const auto wave =
        output(second_order(40e3, bandwidth_hz), pulses, {0.0, 1.0 / 40e3 / samples, samples * (settle + 3 * half)});
    const auto amplitude = envelope(wave, samples);
    Complex sum = 0.0;
    for (std::size_t i = 0; i < 2 * half * samples; ++i)
        sum += std::norm(amplitude[settle * samples + i]) *
               std::polar(1.0, -2.0 * pi * static_cast<double>(i) / static_cast<double>(2 * half * samples));
    return std::abs(sum) / static_cast<double>(2 * half * samples);
}

/// First line of eq. 4, without the Fresnel approximation: equal amplitudes, so that one focus has 324 in its middle.
double equal_sum(double x, bool two_spots) {
    const double k = 2.0 * pi / wavelength;
    Complex sum = 0.0;
    for (int m = 0; m < 324; ++m) {
        const double ex = (m % 18 - 8.5) * 10e-3, ey = (m / 18 - 8.5) * 10e-3;
        const double near = std::sqrt(ex * ex + ey * ey + 0.04);
        const double far = std::sqrt((x - ex) * (x - ex) + ey * ey + 0.04);
        sum += std::polar(two_spots ? std::cos(k * ex * 0.02 / 0.2) : 1.0, k * (near - far));
    }
    return std::abs(sum) / 324.0;
}

struct Peak {
    double at = 0.0, height = 0.0;
};
template <class Function>
Peak highest(Function function, double from, double to, double step) {
    Peak peak;
    for (double x = from; x <= to; x += step)
        if (const double y = function(x); y > peak.height) peak = {x, y};
    return peak;
}

}  // namespace

TEST_CASE("Hoshi: size and force of the focus, and the limit of heat", "[hoshi]") {
    const Medium air{340.0, 1.2, 0.0};
    const double width = focal_diameter(wavelength, 0.2, 0.18);
    REQUIRE(width / millimetre == Approx(18.889).margin(0.0005));
    REQUIRE(focal_depth(wavelength, 0.2, 0.18) / millimetre == Approx(41.975).margin(0.0005));
    const double peak = radiation_pressure(36.0 * 324.0 * std::numbers::sqrt2, air);
    REQUIRE(peak == Approx(1961.5).margin(0.05));
    // Eq. 5 on eq. 4: the closed form of the field over its square.
    const double half = pi / wavelength / 0.2 * 0.01;  // kd/2r
    const auto field = [&](Vec3 at) {
        const auto factor = [&](double u) { return u == 0.0 ? 18.0 : std::sin(18.0 * half * u) / std::sin(half * u); };
        return Complex(36.0 * std::numbers::sqrt2 * factor(at.x) * factor(at.y));
    };
    const double force = force_through_square(field, air, {}, width, wavelength / 2.0);
    REQUIRE(force * 1e3 == Approx(142.93).margin(0.01));       // the paper: 143
    REQUIRE(force / peak * 1e6 == Approx(72.9).margin(0.05));  // mm²
    // 100 W/cm² at the peak of totally reflected sound is 2I/c: 428.65 mN, and the paper says 428.
    REQUIRE(force / peak * 2.0 * 1e6 / 340.0 * 1e3 == Approx(428.65).margin(0.05));
}

TEST_CASE("Hoshi: what the air takes from the energy", "[hoshi]") {
    Array array = find_array("hoshi-18x18");
    array.transducer.pattern = Pattern::point;
    const Element element{};
    const auto kept = [&](double absorption, double z) {
        Array absorbing = array;
        absorbing.medium.absorption_np_m = absorption;
        return std::norm(propagation(absorbing, element, {0, 0, z})) /
               std::norm(propagation(array, element, {0, 0, z}));
    };
    REQUIRE(db_to_np(1.0) == Approx(0.115).margin(0.0002));  // 100 dB in 100 m
    REQUIRE(1.0 - kept(0.115, 0.2) == Approx(0.045).margin(0.0005));
    REQUIRE(1.0 - kept(16.0 * 0.115, 0.2) == Approx(0.52).margin(0.005));  // 160 kHz, as the square of the frequency
    REQUIRE(kept(0.115, 0.4) == Approx(0.912).margin(0.0005));
}

TEST_CASE("Hoshi: the frequency response of the radiation pressure, and the bandwidth that the paper's needs",
          "[hoshi]") {
    const auto response_db = [](double bandwidth, double f) {
        return 20.0 * std::log10(fundamental(bandwidth, f) / fundamental(bandwidth, 10.0));
    };
    REQUIRE(response_db(2000.0, 200.0) == Approx(-0.17).margin(0.03));
    REQUIRE(response_db(2000.0, 500.0) == Approx(-0.97).margin(0.05));
    REQUIRE(response_db(2000.0, 1000.0) == Approx(-3.01).margin(0.1));
    // Measured: −5.8 dB at 1 kHz, rises of 0.5 ms and nearly 1 ms.
    REQUIRE(response_db(1195.0, 1000.0) == Approx(-5.8).margin(0.15));
    const double tau = second_order(40e3, 1195.0).time_constant_s();
    REQUIRE(tau * 1e6 == Approx(266.0).margin(1.0));
    REQUIRE(-tau * std::log(1.0 - 0.9) * 1e3 == Approx(0.61).margin(0.005));
    REQUIRE(-tau * std::log(1.0 - std::sqrt(0.95)) * 1e3 == Approx(0.98).margin(0.005));
}

TEST_CASE("Hoshi: two spots and the first copy, by the sum of eq. 4 with and without Fresnel's approximation",
          "[hoshi]") {
    // Eq. 4 and 9 in closed form: the two spots are two patterns, each with half of the drives' amplitude.
    const auto fresnel = [](double x) {
        const double u = pi * 0.01 * x / wavelength / 0.2;
        return std::abs(std::sin(u)) < 1e-12 ? 1.0 : std::abs(std::sin(18.0 * u) / std::sin(u)) / 18.0;
    };
    const auto signed_pattern = [](double x) {
        const double u = pi * 0.01 * x / wavelength / 0.2;
        return std::abs(u) < 1e-12 ? 1.0 : std::sin(18.0 * u) / std::sin(u) / 18.0;
    };
    const auto two = [&](double x) { return std::abs(signed_pattern(x - 0.02) + signed_pattern(x + 0.02)) / 2.0; };
    const Peak approximate = highest(two, 0.01, 0.035, 1e-5);
    REQUIRE(approximate.at / millimetre == Approx(20.4).margin(0.05));
    REQUIRE(approximate.height == Approx(0.530).margin(0.0005));
    REQUIRE(two(0.0) == Approx(0.056).margin(0.0005));
    const Peak copy = highest(fresnel, 0.15, 0.26, 1e-4);
    REQUIRE(copy.at / millimetre == Approx(170.0).margin(0.11));
    REQUIRE(copy.height == Approx(1.0).margin(0.001));
    const Peak exact = highest([](double x) { return equal_sum(x, true); }, 0.01, 0.035, 5e-5);
    REQUIRE(exact.at / millimetre == Approx(22.44).margin(0.06));
    REQUIRE(exact.height == Approx(0.520).margin(0.0005));
    REQUIRE(equal_sum(22.0e-3, true) == Approx(0.519).margin(0.0005));
    REQUIRE(equal_sum(0.0, true) == Approx(0.056).margin(0.0005));
    const Peak exact_copy = highest([](double x) { return equal_sum(x, false); }, 0.15, 0.26, 2e-4);
    REQUIRE(exact_copy.at / millimetre == Approx(210.0).margin(0.6));
    REQUIRE(exact_copy.height == Approx(0.30).margin(0.005));
    // The library has the decay with distance, too, and so 0.516 at 22.4 mm.
    Array array = find_array("hoshi-18x18");
    array.transducer.pattern = Pattern::point;
    auto drives = ideal_drives(array, from_mm(0, 0, 200));
    const double single = std::abs(pressure(array, drives, from_mm(0, 0, 200)));
    for (std::size_t m = 0; m < drives.size(); ++m)
        drives[m] *= std::cos(2.0 * pi / wavelength * array.elements[m].position.x * 0.02 / 0.2);
    const Peak ours = highest(
        [&](double x) {
            return std::abs(pressure(array, drives, {x, 0, 0.2})) / single;
        },
        0.018, 0.026, 1e-4);
    REQUIRE(ours.at / millimetre == Approx(22.4).margin(0.11));
    REQUIRE(ours.height == Approx(0.5162).margin(0.0005));
}

TEST_CASE("segments: nine amplitudes, by the carrier in the pulses themselves", "[hoshi]") {
    const double table[] = {0, .19509, .38268, .55557, .70711, .83147, .92388, .98079, 1};
    const double radiation[] = {0, .03806, .14645, .30866, .5, .69134, .85355, .96194, 1};
    constexpr double segment_s = 1.5625e-6;
    for (std::uint32_t length = 0; length <= 8; ++length)
        for (std::uint32_t start = 0; start < 16; ++start) {
            const SegmentPulse pulse{start, length};
            const Complex drive = drive_of(pulse, hoshi_segments);
            REQUIRE(std::abs(drive) == Approx(table[length]).margin(5e-6));
            REQUIRE(std::norm(drive) == Approx(radiation[length]).margin(5e-6));
            if (length == 0) continue;
            const DrivePulse edges{start * segment_s, (start + length) * segment_s};
            const Complex carrier = carrier_component({&edges, 1}, 40e3, 25e-6);
            // Drives count their phase from where a pulse of full strength begins, a quarter of a period before its
            // middle.
            REQUIRE(std::abs(drive - carrier * Complex(0.0, 1.0)) < 1e-9);
            REQUIRE(segment_pulse(drive, hoshi_segments) == pulse);
        }
    REQUIRE(segments_of("hoshi").count == 16);
    REQUIRE_REFUSED(segments_of("16"));
    REQUIRE_REFUSED(segment_pulse(1.01, hoshi_segments));
    REQUIRE_THROWS_AS(segment_pulse(std::nan(""), hoshi_segments), Error);
}

TEST_CASE("segments: no pulse comes nearer to a drive", "[hoshi]") {
    std::mt19937_64 g(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    std::uniform_real_distribution<double> amplitude(0.0, 1.0), phase(-pi, pi);
    for (int i = 0; i < 2000; ++i) {
        const Complex drive = std::polar(amplitude(g), phase(g));
        const SegmentPulse found = segment_pulse(drive, hoshi_segments);
        // Exhaustively: the length whose angle asin(a) is nearest, and of its places the nearest phase.
        const double wanted = std::asin(std::abs(drive)), got = pi * found.length / 16.0;
        for (std::uint32_t length = 0; length <= 8; ++length)
            REQUIRE(std::abs(got - wanted) <= std::abs(pi * length / 16.0 - wanted) + 1e-12);
        if (found.length == 0) continue;
        const auto off = [&](std::uint32_t start) {
            const Complex made = drive_of({start, found.length}, hoshi_segments);
            return std::abs(std::arg(made / drive));
        };
        REQUIRE(off(found.start) <= pi / 16.0 + 1e-9);
        for (std::uint32_t start = 0; start < 16; ++start) REQUIRE(off(found.start) <= off(start) + 1e-9);
    }
}

TEST_CASE("segments: 16 phases keep 0.9940 of the pressure", "[hoshi]") {
    const Array array = find_array("hoshi");
    double kept = 0.0;
    int count = 0;
    for (const Vec3 position : PositionGrid{}.positions()) {
        if (!array.unreachable(position).empty()) continue;
        const Focus focus{position};
        const auto exact = superposed_drives(array, {&focus, 1});
        kept += std::abs(pressure(array, in_segments(exact, hoshi_segments), position)) /
                std::abs(pressure(array, exact, position));
        ++count;
    }
    CAPTURE(count);
    REQUIRE(count > 300);
    // Errors that are even over a segment keep sin(x)/x, x = π/16, which is 0.99359.
    REQUIRE(kept / count == Approx(0.9940).margin(0.0007));
}

TEST_CASE("segments: records on the device's clock, and on one that does not divide", "[hoshi]") {
    const Array array = find_array("hoshi");
    const Core core = core_of_array("hoshi");
    REQUIRE(core.parameters.clock_hz == 25'600'000);
    REQUIRE(core.parameters.channels == 324);
    const Timer timer = choose_timer(array, core);
    REQUIRE(timer.cycle_clocks() == 640);  // 16 segments of 40 clocks
    const Focus focus{from_mm(13, -27, 200)};
    const auto drives = superposed_drives(array, {&focus, 1});
    const Record record = in_segments(quantise(drives, timer, 324), timer, hoshi_segments);
    const std::uint32_t segment = timer.cycle_ticks / 16;
    REQUIRE(record.pulse_length == 8 * segment);
    std::size_t different = 0;
    for (std::size_t m = 0; m < 324; ++m) {
        REQUIRE(record.timings[m] % segment == 0);
        REQUIRE(record.timings[m] < timer.cycle_ticks);
        // The pulse for the drive itself; the tick before it can round it over an edge, rarely.
        if (record.timings[m] / segment != segment_pulse(drives[m], hoshi_segments).start) ++different;
    }
    REQUIRE(different <= 16);  // of 324: a tick is 1/20 of a segment
    // 50 MHz: 250 ticks. A border is off by half a tick at most, and the full pulse is the timer's own.
    const Timer other{50e6, 5, 250, 125};
    for (std::uint16_t tick = 0; tick < 250; ++tick) {
        const Record one = in_segments(Record{250, 5, 125, {tick}}, other, hoshi_segments);
        const double border = std::round(tick * 16 / 250.0);
        REQUIRE(one.pulse_length == 125);
        REQUIRE(std::abs(std::remainder(one.timings[0] - border * 15.625, 250.0)) <= 0.5);
    }
    REQUIRE(in_segments(Record{250, 5, 7, {3}}, other, hoshi_segments).pulse_length == 0);
    REQUIRE(in_segments(Record{250, 5, 8, {3}}, other, hoshi_segments).pulse_length == 16);
    const Record silent{250, 5, 125, {interface::silent_timing}};
    REQUIRE(in_segments(silent, other, hoshi_segments).timings == silent.timings);
}

TEST_CASE("position table: 324 positions in nine units of 36 channels", "[hoshi]") {
    const Array array = find_array("hoshi");
    Array wide = array;
    wide.reach_angle_rad = 1.2;
    const std::vector<Vec3> positions = PositionGrid{}.positions();
    const PositionTable table = position_table(wide, positions, hoshi_segments);
    const auto units = square_units(array);
    REQUIRE(units.size() == 9);
    std::vector<int> seen(324);
    std::size_t bytes = 0;
    const double k = 2.0 * pi / wavelength;
    for (const auto& unit : units) {
        REQUIRE(unit.size() == 36);
        for (const std::size_t channel : unit) ++seen[channel];
        const std::vector<std::uint8_t> memory = packed(table, unit, hoshi_segments);
        bytes += memory.size();
        std::size_t bit = 0;
        const auto take = [&](int count) {
            int value = 0;
            for (int i = 0; i < count; ++i, ++bit) value = 2 * value + (memory[bit / 8] >> (7 - bit % 8) & 1);
            return value;
        };
        for (const Vec3 position : positions) {
            // The pulses arrive together: start + k·R is the same for all channels of a position, half a segment off at
            // most.
            Complex mean = 0.0;
            std::vector<double> arrival;
            for (const std::size_t channel : unit) {
                const double segment = take(4);
                REQUIRE(take(3) == 7);  // full strength
                const double turns = segment / 16.0 + k / (2.0 * pi) * distance(array.elements[channel], position);
                arrival.push_back(turns);
                mean += std::polar(1.0, 2.0 * pi * turns);
            }
            const double centre = std::arg(mean) / (2.0 * pi);
            for (const double turns : arrival) REQUIRE(std::abs(std::remainder(turns - centre, 1.0)) < 1.0 / 16.0);
        }
    }
    REQUIRE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
    REQUIRE(bytes == 91'854);  // 324 positions × 324 channels × 7 bits; 52,488 with the phases alone
    for (const std::size_t channel : units[4]) {  // the middle unit's elements are next to each other
        REQUIRE(std::abs(array.elements[channel].position.x) < 30e-3);
        REQUIRE(std::abs(array.elements[channel].position.y) < 30e-3);
    }
    REQUIRE_REFUSED(position_table(array, std::vector<Vec3>{{0.5, 0, 0.1}}, hoshi_segments));
    REQUIRE_REFUSED(square_units(find_array("tile-10x10")));
    PositionTable silent = table;
    silent.pulses[5] = {};
    REQUIRE_REFUSED(packed(silent, units[0], hoshi_segments));
    REQUIRE_REFUSED(packed(table, units[0], Segments{"x", 8}));
}

TEST_CASE("hoshi: what sixteen phases take from foci, and what simulate allows", "[hoshi]") {
    // Δ = π/16: sin(Δ)/Δ of the pressure on average, its square of the radiation pressure.
    const Array array = find_array("tile-10x10");
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(-40.0, 40.0), height(110.0, 180.0);
    Path path;
    while (path.steps.size() < 200)
        if (const Vec3 focus = from_mm(place(random), place(random), height(random)); array.unreachable(focus).empty())
            path.steps.push_back({{{focus}}, 4});
    const Bundle bundle =
        compile(path, array, core_of_array("tile-10x10"), 0, "image", Method::gauss_newton, "hoshi").bundle;
    REQUIRE(bundle.image.records.size() == 200);
    double kept = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < 200; ++i) {
        const RecordMeaning& meaning = bundle.manifest.records[i];
        const FocusLimits limits = limits_of(bundle.manifest, meaning);
        CHECK(limits.expected_kept == Approx(0.99359).margin(1e-5));
        CHECK(limits.least_kept == Approx(0.999 * (0.99359 - 4.0 * 0.00162)).margin(1e-4));
        const FocusCheck check =
            check_record(bundle.manifest, meaning, drives_of(bundle.manifest, bundle.image.records[i]));
        CAPTURE(i, meaning.foci.front().position.x, meaning.foci.front().position.y, meaning.foci.front().position.z);
        CHECK(check.pressure_kept >= limits.least_kept);
        CHECK(check.peak_offset_m <= limits.most_offset_m);
        kept += check.pressure_kept / 200.0;
        squares += check.pressure_kept * check.pressure_kept / 200.0;
    }
    CHECK(kept == Approx(0.99359).margin(0.0005));
    CHECK(squares == Approx(0.98722).margin(0.001));

    // Four of a hundred channels that are silent are noticed all the same.
    Record broken = bundle.image.records.front();
    for (const std::size_t channel : {44U, 45U, 54U, 55U}) broken.timings[channel] = 0xFFFF;
    const FocusLimits limits = limits_of(bundle.manifest, bundle.manifest.records.front());
    CHECK(check_record(bundle.manifest, bundle.manifest.records.front(), drives_of(bundle.manifest, broken))
              .pressure_kept < limits.least_kept);
    // An image that says nothing of segments keeps the contract's limits.
    Manifest exact = bundle.manifest;
    exact.quantise.clear();
    CHECK(limits_of(exact, exact.records.front()).least_kept == 0.999);
    CHECK(limits_of(exact, exact.records.front()).most_offset_m == 0.2e-3);
}
