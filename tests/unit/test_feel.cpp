// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/acoustics/transient.hpp"
#include "haptogram/perception/feel.hpp"
#include "haptogram/perception/felt.hpp"
#include "haptogram/perception/magnitude.hpp"
#include "haptogram/perception/verdict.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/timeline.hpp"

using namespace haptogram;
using namespace haptogram::perception;
using std::numbers::pi;

namespace {

using Complex = std::complex<double>;

Vec3 leaning(double degrees) { return {std::sin(degrees * pi / 180.0), 0.0, -std::cos(degrees * pi / 180.0)}; }

/// Sets of drives one after the other, each for so many carrier periods.
DriveSequence sequence_of(std::vector<std::vector<Complex>> drives, const std::vector<std::uint64_t>& periods) {
    DriveSequence sequence;
    sequence.drives = std::move(drives);
    for (std::size_t i = 0; i < periods.size(); ++i) sequence.steps.push_back({i, periods[i], 1});
    return sequence;
}

DriveSequence steady(const Array& array, Vec3 focus) { return sequence_of({ideal_drives(array, focus)}, {1}); }

/// A focus under an amplitude modulation, in steps of one carrier period.
DriveSequence modulated(const Array& array, Vec3 focus, std::size_t periods, double (*envelope)(double)) {
    std::vector<std::vector<Complex>> drives;
    for (std::size_t i = 0; i < periods; ++i) {
        drives.push_back(ideal_drives(array, focus));
        for (Complex& drive : drives.back())
            drive *= envelope((static_cast<double>(i) + 0.5) / static_cast<double>(periods));
    }
    return sequence_of(std::move(drives), std::vector<std::uint64_t>(periods, 1));
}

/// The array and its image behind a plane mirror.
Array mirrored(const Array& array, Vec3 point, Vec3 out) {
    Array both = array;
    for (const Element& element : array.elements)
        both.elements.push_back({element.position - out * (2.0 * dot(element.position - point, out)),
                                 element.normal - out * (2.0 * dot(element.normal, out))});
    return both;
}

}  // namespace

TEST_CASE("skin: a wave that comes at an angle leaves cos² of its radiation pressure", "[feel]") {
    Array one = find_array("tile-10x10");
    one.elements = {{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}};
    const Vec3 point{0.0, 0.0, 0.2};
    const std::vector<Complex> drives = ideal_drives(one, point);
    const double straight = radiation_pressure(pressure(one, drives, point), one.medium);
    const auto [degrees, left] = GENERATE(std::pair(0.0, 1.0), std::pair(15.0, 0.933), std::pair(30.0, 0.75),
                                          std::pair(45.0, 0.5), std::pair(60.0, 0.25), std::pair(75.0, 0.067));
    const auto waves = waves_at_patch(one, point, leaning(degrees));
    CHECK(radiation_pressure(sound_at_patch(waves, drives), one.medium) / straight == Approx(left).margin(5e-4));
    // The other side of the skin is in its shadow.
    const auto behind = waves_at_patch(one, point, leaning(degrees) * -3.0);
    CHECK(radiation_pressure(sound_at_patch(behind, drives), one.medium) == 0.0);
}

TEST_CASE("skin: the pressure of an array is that of the array and its mirror image", "[feel]") {
    // Excess pressure on a rigid wall is ⟨p²⟩/(2ρc²) − ρ⟨v²⟩/2 of the sum of both fields, whose velocity has no part
    // through the wall. The velocity here is the exact gradient of the pressure.
    const Array array = find_array("tile-10x10");
    const Vec3 focus = from_mm(10, -5, 150);
    const std::vector<Complex> drives = ideal_drives(array, focus);
    std::vector<Complex> twice = drives;
    twice.insert(twice.end(), drives.begin(), drives.end());
    const double scale = radiation_pressure(pressure(array, drives, focus), array.medium);
    for (const double degrees : {0.0, 20.0, 40.0})
        for (const Vec3 away : {Vec3{}, from_mm(4, 0, 0), from_mm(-3, 3, 0)}) {
            const Vec3 out = leaning(degrees), point = focus + away;
            const Array both = mirrored(array, point, out);
            const ComplexVec3 v = particle_velocity(both, twice, point);
            const double rho = array.medium.density_kg_m3, c = array.medium.speed_m_s;
            const double through = std::norm(v.x * out.x + v.y * out.y + v.z * out.z);
            const double squares = std::norm(v.x) + std::norm(v.y) + std::norm(v.z);
            CHECK(through <= 1e-12 * squares + 1e-18);
            const double expected = std::norm(pressure(both, twice, point)) / (4.0 * rho * c * c) - rho * squares / 4.0;
            const double found =
                radiation_pressure(sound_at_patch(waves_at_patch(array, point, out), drives), array.medium);
            INFO(degrees << " degrees, " << away.x << " " << away.y);
            CHECK(std::abs(found - expected) <= 0.005 * scale);
        }
    CHECK_REFUSED(waves_at_patch(array, focus, {}));
}

TEST_CASE("skin: the force on a disc", "[feel]") {
    const Array array = find_array("tile-10x10");
    const Vec3 focus = from_mm(0, 0, 150);
    const SkinForce felt = force_on_skin(array, steady(array, focus), {focus, {0, 0, -2}});
    CHECK(felt.force_n.front() == Approx(steady_force(array, ideal_drives(array, focus), focus)).epsilon(1e-6));
    CHECK(felt.pressure_pa.front() ==
          Approx(radiation_pressure(pressure(array, ideal_drives(array, focus), focus), array.medium)).epsilon(1e-3));
    CHECK(felt.tilt == 1.0);
    CHECK(modulation_depth(felt.force_n) == Approx(0.0).margin(1e-9));
    // Sums of a finer midpoint rule over the same disc, and over a hand's width of skin.
    double sum = 0.0, wide = 0.0;
    constexpr int across = 60;
    for (int i = 0; i < across; ++i)
        for (int j = 0; j < across; ++j) {
            const double x = ((i + 0.5) / across - 0.5) * 0.02, y = ((j + 0.5) / across - 0.5) * 0.02;
            if (std::hypot(x, y) > 0.01) continue;
            const auto waves = waves_at_patch(array, focus + Vec3{x, y, 0.0}, {0, 0, -1});
            sum += radiation_pressure(sound_at_patch(waves, ideal_drives(array, focus)), array.medium) * 0.02 * 0.02 /
                   (across * across);
        }
    CHECK(felt.force_n.front() == Approx(sum).epsilon(0.005));
    constexpr double hand_m = 0.08;
    for (int i = 0; i < 2 * across; ++i)
        for (int j = 0; j < 2 * across; ++j) {
            const double step = hand_m / (2 * across), x = (i + 0.5) * step - 0.04, y = (j + 0.5) * step - 0.04;
            if (std::hypot(x, y) > hand_m / 2) continue;
            const auto waves = waves_at_patch(array, focus + Vec3{x, y, 0.0}, {0, 0, -1});
            wide += radiation_pressure(sound_at_patch(waves, ideal_drives(array, focus)), array.medium) * step * step;
        }
    CHECK(force_on_skin(array, steady(array, focus), {focus}, hand_m).force_n.front() == Approx(wide).epsilon(0.005));
    CHECK_REFUSED(force_on_skin(array, steady(array, focus), {focus}, 0.21));
    CHECK_REFUSED(force_on_skin(array, {}, {focus}));
    CHECK_REFUSED(force_on_skin(array, steady(array, focus), {focus}, 0.0));
    CHECK_REFUSED(force_on_skin(array, steady(array, focus), {{NAN, 0, 0}}));
}

TEST_CASE("skin: the force over time is the sum of the pressures on the disc", "[feel]") {
    // Foci in turn, on tilted skin that does not lie in all of them; some drives are weak.
    const Array array = find_array("tile-10x10");
    DriveSequence sequence;
    for (int i = 0; i < 6; ++i) {
        sequence.drives.push_back(ideal_drives(array, from_mm(12.0 * i - 30, 5.0 * (i % 2), 140)));
        for (Complex& drive : sequence.drives.back()) drive *= 1.0 - 0.15 * i;
        sequence.steps.push_back({static_cast<std::size_t>(i), i % 3 == 0 ? 1U : 7U, 1});
    }
    const SkinPlace place{from_mm(5, -3, 141), {0.3, 0.2, -1.0}};
    const SkinForce felt = force_on_skin(array, sequence, place);
    const Vec3 out = place.normal * (1.0 / norm(place.normal));
    Vec3 along = Vec3{1.0, 0.0, 0.0} - out * out.x;
    along = along * (1.0 / norm(along));
    const Vec3 across = cross(out, along);
    std::vector<double> sum(sequence.periods());
    double area = 0.0;
    for (const DiscNode& node : disc_nodes(default_contact_m, array.wavelength_m())) {
        area += node.weight;
        const auto waves = waves_at_patch(array, place.position + along * node.x + across * node.y, out);
        std::vector<PatchSound> sounds;
        for (const auto& drives : sequence.drives) sounds.push_back(sound_at_patch(waves, drives));
        follow(sequence, array.transducer.bandwidth_hz, sounds, [&](std::uint64_t period, const PatchSound& sound) {
            sum[period] += pi * 1e-4 * node.weight * radiation_pressure(sound, array.medium);
        });
    }
    CHECK(area == Approx(1.0).epsilon(1e-12));
    REQUIRE(felt.force_n.size() == sum.size());
    for (std::size_t i = 0; i < sum.size(); ++i) CHECK(felt.force_n[i] == Approx(sum[i]).epsilon(1e-6));
}

TEST_CASE("skin: what the bandwidth leaves of a square modulation", "[feel]") {
    // A one-pole envelope of 2 kHz leaves these of the fundamental of its square, beside a slow modulation
    // (numerically integrated elsewhere): −0.17, −0.97 and −3.01 dB at 200, 500 and 1000 Hz.
    Array array = find_array("tile-10x10");
    array.transducer.bandwidth_hz = 2000.0;
    const Vec3 focus = from_mm(0, 0, 150);
    const auto fundamental = [&](double hz) {
        const auto half = static_cast<std::uint64_t>(std::lround(20000.0 / hz));
        const auto drives = ideal_drives(array, focus);
        const DriveSequence sequence = sequence_of({drives, std::vector<Complex>(drives.size())}, {half, half});
        return lines_of(force_on_skin(array, sequence, {focus}).pressure_pa, 40000.0)[1].amplitude;
    };
    const double slow = fundamental(10.0);
    CHECK(20.0 * std::log10(fundamental(200.0) / slow) == Approx(-0.17).margin(0.02));
    CHECK(20.0 * std::log10(fundamental(500.0) / slow) == Approx(-0.97).margin(0.03));
    CHECK(20.0 * std::log10(fundamental(1000.0) / slow) == Approx(-3.01).margin(0.05));
    // Two foci in turn, beside resonators with flights and pulses.
    const Vec3 left = from_mm(-25, 0, 130), right = from_mm(25, 0, 130);
    for (const std::uint64_t periods : {std::uint64_t{12}, std::uint64_t{40}}) {
        const DriveSequence sequence =
            sequence_of({ideal_drives(array, left), ideal_drives(array, right)}, {periods, periods});
        const std::vector<double> felt = force_on_skin(array, sequence, {left}).pressure_pa;
        const double alone = force_on_skin(array, steady(array, left), {left}).pressure_pa.front();
        const Alternation exact = alternate(array, second_order(array), left, right, periods);
        INFO(periods << " periods");
        CHECK(std::sqrt(*std::max_element(felt.begin(), felt.end()) / alone) == Approx(exact.peak).margin(0.03));
        CHECK(std::accumulate(felt.begin(), felt.end(), 0.0) / static_cast<double>(felt.size()) / alone ==
              Approx(exact.power).margin(0.03));
    }
}

TEST_CASE("spectrum: lines beside the plain sum", "[feel]") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> value(-1.0, 1.0);
    for (const std::size_t count :
         {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{97}, std::size_t{202}, std::size_t{360}}) {
        std::vector<double> samples(count);
        for (double& sample : samples) sample = value(random);
        const std::vector<Line> lines = lines_of(samples, 1000.0);
        REQUIRE(lines.size() == count / 2 + 1);
        for (std::size_t k = 0; k < lines.size(); ++k) {
            Complex sum;
            for (std::size_t n = 0; n < count; ++n)
                sum +=
                    samples[n] * std::polar(1.0, -2.0 * pi * static_cast<double>(k * n) / static_cast<double>(count));
            const double once = k == 0 || 2 * k == count ? 1.0 : 2.0;
            CHECK(lines[k].amplitude == Approx(once * std::abs(sum) / static_cast<double>(count)).margin(1e-12));
            CHECK(lines[k].hz == Approx(1000.0 * static_cast<double>(k) / static_cast<double>(count)));
        }
    }
    CHECK(lines_of({}, 1000.0).empty());
    // Table of IEC 61672-1, dB to one digit, at the exact frequencies that its nominal ones stand for.
    for (const auto& [hz, db] : {std::pair(31.623, -39.4), std::pair(100.0, -19.1), std::pair(1000.0, 0.0),
                                 std::pair(3981.07, 1.0), std::pair(10000.0, -2.5), std::pair(15848.9, -6.6)})
        CHECK(20.0 * std::log10(a_weighting(hz)) == Approx(db).margin(0.1));
}

TEST_CASE("felt: thresholds of vibration, and what they rest on", "[feel]") {
    const Tables tables = find_tables();
    const double square = 4.0 / pi * gram_force_n;  // the fundamental over the mean of a square wave of 50 %
    CHECK(least_vibration(tables, perception::Region::palm, 200.0, 1.0).force_n == Approx(0.05903 * square));
    CHECK(least_vibration(tables, perception::Region::palm, 80.0, 1.0).force_n == Approx(0.06903 * square));
    CHECK(least_vibration(tables, perception::Region::finger, 300.0, 10.0).force_n == Approx(0.1161 * square));
    CHECK(least_vibration(tables, perception::Region::palm, 200.0, 1.0).basis == Basis::tables);
    // The displacement curve has 40 dB a decade below 250 Hz and above 300 Hz, and is flat at 12.5 dB up to 40 Hz.
    const LeastForce at_50 = least_vibration(tables, perception::Region::palm, 50.0, 1.0);
    CHECK(at_50.basis == Basis::displacement);
    CHECK(at_50.force_n / (0.06903 * square) == Approx(std::pow(80.0 / 50.0, 2.0)));
    CHECK(least_vibration(tables, perception::Region::palm, 400.0, 1.0).force_n / (0.06903 * square) ==
          Approx(std::pow(400.0 / 300.0, 2.0)));
    CHECK(least_vibration(tables, perception::Region::palm, 12.0, 1.0).force_n ==
          Approx(least_vibration(tables, perception::Region::palm, 30.0, 1.0).force_n));
    CHECK(least_vibration(tables, perception::Region::palm, 9.0, 1.0).basis == Basis::none);
    CHECK(least_vibration(tables, perception::Region::palm, 1001.0, 1.0).basis == Basis::none);
    CHECK_REFUSED(least_vibration(tables, perception::Region::palm, 200.0, 0.5));

    const std::vector<Line> lines = {{0.0, 1.0}, {5.0, 1.0}, {50.0, 2e-3}, {200.0, 2e-3}, {1100.0, 1.0}};
    const Felt felt = felt_of(lines, tables, perception::Region::palm, 1.0);
    REQUIRE(felt.lines.size() == 2);
    CHECK(felt.lines[0].hz == 200.0);
    CHECK(felt.lines[0].over_db == Approx(20.0 * std::log10(2e-3 / (0.05903 * square))));
    REQUIRE(felt.magnitude);
    // Multimodal eq. 10 between 180 and 240 Hz, linear in the logarithm of the frequency.
    const double gf = 2e-3 / square, place = std::log(200.0 / 180.0) / std::log(240.0 / 180.0);
    const double low = -12.46 * gf * gf + 20.88 * gf - 0.1070, high = -9.518 * gf * gf + 12.93 * gf + 0.1897;
    CHECK(*felt.magnitude == Approx(std::lerp(low, high, place)));
    CHECK_SAID(felt_of(std::vector<Line>{{200.0, 1e-5}}, tables, perception::Region::palm, 1.0).no_magnitude);
    CHECK_SAID(felt_of(std::vector<Line>{{50.0, 1e-3}}, tables, perception::Region::palm, 1.0).no_magnitude);
    CHECK_SAID(felt_of(std::vector<Line>{{200.0, 1.0}}, tables, perception::Region::palm, 1.0).no_magnitude);
    CHECK_SAID(felt_of(lines, tables, perception::Region::finger, 1.0).no_magnitude);
}

TEST_CASE("verdict: lines of one channel add up, and what is not known decides between three answers", "[feel]") {
    const Tables tables = find_tables();
    const auto palm = perception::Region::palm;
    const auto least = [&](double hz) { return least_vibration(tables, palm, hz, 1.0).force_n; };
    const auto over = [&](const std::vector<Line>& lines) { return felt_of(lines, tables, palm, 1.0).over_db; };
    CHECK(over({{200.0, least(200.0)}, {100.0, least(100.0)}, {400.0, least(400.0)}, {50.0, least(50.0)}}) ==
          Approx(20.0 * std::log10(2.0)));
    CHECK(over({{20.0, least(20.0)}, {30.0, least(30.0)}}) == Approx(0.0).margin(1e-9));
    CHECK(over({}) == -INFINITY);

    const double half_db = 10.0 * std::log10(0.06903 / 0.05903);
    const double bare_db = 20.0 * std::log10((0.06794 + 0.08392) / (0.05903 + 0.06903));
    ExpectedLevel level{1.0, 1.0, 2.0, ""};
    const auto at = [&](double over_db, double hz, double grip_n = 1.0, double largest_n = 0.0,
                        std::optional<double> rounds_hz = {}) {
        const double force = least_vibration(tables, palm, hz, grip_n).force_n * std::pow(10.0, over_db / 20.0);
        const Felt felt = felt_of(std::vector<Line>{{hz, force}}, tables, palm, grip_n);
        return verdict_of(felt, level, tables, palm, grip_n, largest_n, rounds_hz);
    };
    const Verdict clear = at(3.0, 200.0);
    CHECK(clear.over_db == Approx(3.0));
    CHECK(clear.least_db == Approx(3.0 - std::hypot(1.0, half_db)));
    CHECK(clear.most_db == Approx(3.0 + std::hypot(2.0, half_db) + bare_db));
    CHECK(clear.answer() == Answer::felt);
    CHECK(at(0.5, 200.0).answer() == Answer::perhaps);
    CHECK(at(-1.0, 200.0).answer() == Answer::perhaps);
    CHECK(at(-5.0, 200.0).answer() == Answer::not_felt);
    CHECK(at(3.0, 50.0).answer() == Answer::perhaps);  // where the tables do not reach, less is known
    CHECK(at(3.0, 50.0).least_db == Approx(3.0 - std::hypot(1.0, half_db, 5.0)));
    CHECK(at(0.0, 200.0, 3.0).most_db < at(0.0, 200.0, 1.0).most_db);  // no bare hand holds 3 N
    // A focus that comes round may be felt as one that rests under a square wave.
    const double strong_n = pi / 2.0 * least(200.0);
    CHECK(at(-20.0, 70.0, 1.0, strong_n, 10.0).most_db == Approx(std::hypot(2.0, half_db) + bare_db));
    CHECK(at(-20.0, 70.0, 1.0, strong_n, 10.0).answer() == Answer::perhaps);
    for (const double hz : {4.0, 201.0}) CHECK(at(-20.0, 70.0, 1.0, strong_n, hz).answer() == Answer::not_felt);

    const Verdict nothing{};
    CHECK(nothing.answer() == Answer::not_felt);
    const Verdict weak = at(-5.0, 200.0), unsure = at(0.0, 200.0);
    CHECK(answer_of(std::vector{clear, clear}) == Answer::felt);
    CHECK(answer_of(std::vector{clear, weak}) == Answer::perhaps);
    CHECK(answer_of(std::vector{unsure, weak}) == Answer::perhaps);
    CHECK(answer_of(std::vector{weak, nothing}) == Answer::not_felt);
    for (const auto& [places, begins] :
         {std::pair(std::vector{clear, clear}, "felt: clear everywhere, "),
          std::pair(std::vector{clear, weak}, "perhaps: felt at 1, "), std::pair(std::vector{weak}, "not felt: "),
          std::pair(std::vector{nothing}, "not felt: nothing alternates")})
        CHECK(sentence_of(places).starts_with(begins));
}

TEST_CASE("level: what is expected of a transducer", "[feel]") {
    const Transducer tile = find_array("tile-10x10").transducer, hoshi = find_array("hoshi-18x18").transducer;
    // Hoshi weighed 16 of 134 mN on his array, with 24 V.
    CHECK(expected_level(hoshi).source_pa_m == Approx(10.18 * std::sqrt(16.0 / 134.0)).epsilon(0.01));
    CHECK(expected_level(tile, 12.0).source_pa_m == Approx(expected_level(tile, 24.0).source_pa_m / 2.0));
    CHECK(expected_level(tile).source_pa_m / expected_level(hoshi).source_pa_m ==
          Approx(20.0 / 24.0 * std::pow(10.0, (120.0 - 121.5) / 20.0)).epsilon(0.01));
    Transducer own = tile;
    own.source_pa_m = 3.0;
    CHECK(expected_level(own).source_pa_m == 3.0);
    CHECK(expected_level(own).less_db == Approx(-40.0 * std::log10(share_of_data_sheet)));
    own.measured = "by a balance";
    CHECK(expected_level(own).less_db == 0.0);
    for (const Transducer& other : {own, tile}) CHECK_SAID(level_text(other));
    CHECK_REFUSED(expected_level(own, 12.0));
    CHECK_REFUSED(expected_level(tile, 0.0));
}

TEST_CASE("skin waves: the deflection under a moving focus", "[feel]") {
    // The same sum, computed with numpy's inverse FFT for a Gaussian whose a is 4.3/1.177 mm.
    SkinMembrane skin;
    skin.focus_width_m = 2.0 * std::sqrt(std::numbers::ln2) * 4.3e-3 / 1.177;
    const auto [speed, gain] =
        GENERATE(std::pair(0.0, 1.0), std::pair(1.0, 1.006), std::pair(3.0, 1.067), std::pair(5.0, 1.233),
                 std::pair(6.0, 1.376), std::pair(7.0, 1.229), std::pair(8.0, 1.041), std::pair(12.0, 0.642));
    CHECK(deflection_over_static(speed, skin) == Approx(gain).epsilon(0.01));
    CHECK_REFUSED(deflection_over_static(13.0));
    CHECK_REFUSED(deflection_over_static(NAN));
}

TEST_CASE("noise: the reference, steps and steadiness", "[feel]") {
    Array array = find_array("tile-10x10");
    const Vec3 focus = from_mm(0, 0, 150);
    CHECK(noise_of(array, steady(array, focus)).relative_db == -INFINITY);
    const auto sine = [](double x) { return 0.5 + 0.5 * std::sin(2.0 * pi * x); };
    const Noise reference = noise_of(array, modulated(array, focus, 200, sine));
    CHECK(reference.relative_db == Approx(0.0).margin(0.5));  // the bandwidth takes some at 400 Hz
    CHECK(reference.relative_db < 0.0);
    CHECK(reference.loudest_hz == Approx(400.0));  // ω² and the ear weigh more than the ¼ of the amplitude
    CHECK(reference.largest_step_deg == Approx(0.0).margin(1e-9));
    const auto half = [](double x) { return 0.25 + 0.25 * std::sin(2.0 * pi * x); };
    CHECK(noise_of(array, modulated(array, focus, 200, half)).relative_db - reference.relative_db ==
          Approx(40.0 * std::log10(0.5)));
    // Phases that jump by 90 degrees: a carrier of bandwidth B dips. The dip over time, from the formula of a single
    // carrier, e^{−t/τ}: |1 + (j − 1)·e|² = 1 − 2e + 2e².
    std::vector<Complex> turned = ideal_drives(array, focus);
    for (Complex& drive : turned) drive *= Complex(0.0, 1.0);
    const DriveSequence jumps = sequence_of({ideal_drives(array, focus), turned}, {100, 100});
    const Noise jumping = noise_of(array, jumps);
    CHECK(jumping.largest_step_deg == Approx(90.0));
    CHECK(jumping.relative_db > 0.0);
    std::vector<double> squares;
    const double full = std::pow(array.transducer.source_pa_m, 2) * static_cast<double>(array.elements.size());
    for (int i = 0; i < 200; ++i) {
        const double e = std::exp(-pi * array.transducer.bandwidth_hz * (i % 100 + 0.5) / 40000.0);
        squares.push_back(full * (1.0 - 2.0 * e + 2.0 * e * e));
    }
    double power = 0.0, unit = 0.0;
    const auto heard = [](double hz, double amplitude) {
        return std::pow(amplitude * std::pow(2.0 * pi * hz, 2) * a_weighting(hz), 2);
    };
    for (const Line& line : lines_of(squares, 40000.0))
        if (line.hz >= 20.0 && line.hz <= 16000.0) power += heard(line.hz, line.amplitude);
    unit = heard(200.0, full / 2.0) + heard(400.0, full / 8.0);
    CHECK(jumping.relative_db == Approx(10.0 * std::log10(power / unit)).margin(0.01));
}

TEST_CASE("exposure: levels at an ear", "[feel]") {
    const Array array = find_array("tile-10x10");
    const auto a = ideal_drives(array, from_mm(-20, 0, 150)), b = ideal_drives(array, from_mm(20, 0, 150));
    const DriveSequence sequence = sequence_of({a, b}, {1, 3});
    const std::vector<Vec3> ears = {from_mm(0, -400, 300), from_mm(300, 100, 100)};
    const std::vector<Exposure> found = exposure(array, sequence, ears);
    REQUIRE(found.size() == 2);
    for (std::size_t i = 0; i < ears.size(); ++i) {
        const double first = std::norm(pressure(array, a, ears[i])), second = std::norm(pressure(array, b, ears[i]));
        CHECK(found[i].mean_db == Approx(sound_level_db(std::sqrt(0.25 * first + 0.75 * second))).margin(0.01));
        CHECK(found[i].most_db == Approx(sound_level_db(std::sqrt(std::max(first, second)))).margin(0.01));
    }
    const Exposure around = loudest_around(array, sequence);
    CHECK(norm(around.ear) == Approx(0.5));
    for (const Vec3 point : {from_mm(0, 0, 500), from_mm(300, 0, 400), from_mm(0, 500, 0)})
        CHECK(exposure(array, sequence, {&point, 1}).front().mean_db <= around.mean_db + 1e-3);
}

namespace {

/// Pulses by hand, as a board that computes foci and modulates would play an image for so many passes.
std::vector<Pulse> pulses_of(const Bundle& bundle, int passes) {
    const Image& image = bundle.image;
    std::vector<Pulse> pulses;
    std::uint64_t period = 0;
    for (int pass = 0; pass < passes; ++pass)
        for (const SequenceEntry& entry : image.sequence)
            for (int i = 0; i < entry.dwell; ++i, ++period) {
                const auto place = place_of(image, entry.index);
                if (!place) continue;
                const auto cycle = static_cast<std::uint32_t>(cycle_clocks(image, *place));
                std::uint8_t sample = 255;
                if (image.modulation)
                    sample = image.modulation
                                 ->samples[period / image.modulation->divider % image.modulation->samples.size()];
                const auto words = emission_words(image, emissions_of(image, *place), cycle, sample);
                for (std::uint32_t channel = 0; channel < image.channels; ++channel) {
                    if (words[channel].width == 0) continue;
                    const std::uint64_t rise = 777 + period * cycle + words[channel].rise;
                    pulses.push_back({rise, rise + words[channel].width, channel, entry.index});
                }
            }
    return pulses;
}

/// Mean |p|² at a point.
double mean_square(const Excitation& excitation, Vec3 point) {
    double sum = 0.0, weights = 0.0;
    for (std::size_t i = 0; i < excitation.drives.size(); ++i) {
        sum += excitation.weights[i] * std::norm(pressure(excitation.array, excitation.drives[i], point));
        weights += excitation.weights[i];
    }
    return sum / weights;
}

}  // namespace

TEST_CASE("feel: images of foci, whose records count on behind those of timings, and their pulses", "[feel]") {
    const Vec3 left = from_mm(-15, 0, 140), right = from_mm(15, 0, 140);
    const Path path{{{{{left}}, 30}, {{{right, 0.6}}, 20}, {{}, 10}}, {}};
    const Array array = find_array("tile-10x10");
    const Core core = find_configuration("tile-100-wide");
    const Bundle foci = compile(path, array, core).bundle;
    REQUIRE(foci.image.sequence.front().index == 401);
    const Bundle records = compile(path, array, core, 0, "image", Method::gauss_newton, {}, ImageKind::records).bundle;
    const auto felt = [](const Timeline& timeline) {
        FeelOptions options;
        options.tables = perception::find_tables();
        return feel(timeline, options);
    };
    const Feeling expected = felt(timeline_of(records));
    const Timeline measured = timeline_of(foci.manifest, pulses_of(foci, 4), "pulses.csv");
    for (const Feeling& found :
         {felt(timeline_of(foci)), felt(measured), felt(timeline_of(foci.manifest, "foci.json"))}) {
        REQUIRE(found.places.size() == 2);
        for (std::size_t i = 0; i < 2; ++i) {
            CHECK(distance(found.places[i].place.position, i == 0 ? left : right) < 1e-5);
            // What one focus leaves of the other's carriers depends on their common phases, which are free.
            CHECK(found.places[i].mean_pa == Approx(expected.places[i].mean_pa).epsilon(0.1));
        }
    }
    std::vector<Pulse> foreign = pulses_of(foci, 1);
    foreign.back().index = 2;
    CHECK_REFUSED(timeline_of(foci.manifest, foreign, "pulses.csv"));
}

TEST_CASE("feel: the board's modulation counts with its squares, and with its silence", "[feel]") {
    // Means of the squares of a waveform: ∫ (½ + ½·sin)² = 3/8, and a square's duty.
    const Vec3 focus = from_mm(5, 0, 140);
    const Array array = find_array("tile-10x10");
    const Core core = find_configuration("tile-100-wide");
    Path path{{{{{focus}}, 400}}, {}};
    const Bundle steady = compile(path, array, core).bundle;
    const double whole = mean_square(excitation_of(timeline_of(steady)), focus);
    const auto square = [](double duty) { return [duty](double x) { return x < duty ? 1.0 : 0.0; }; };
    const struct {
        std::function<double(double)> wave;
        double mean;
    } cases[] = {
        {[](double x) { return 0.5 + 0.5 * std::sin(2.0 * pi * x); }, 0.375}, {square(0.5), 0.5}, {square(0.25), 0.25}};
    for (const auto& [wave, mean] : cases)
        for (const int passes : {1, 3}) {
            path.modulation.samples.clear();
            for (int i = 0; i < 200; ++i) path.modulation.samples.push_back(wave((i + 0.5) / 200));
            const Bundle bundle = compile(path, array, core).bundle;
            const std::vector<Pulse> pulses = pulses_of(bundle, passes);
            CAPTURE(mean, passes);
            CHECK(mean_square(excitation_of(timeline_of(bundle.manifest, pulses, "p")), focus) / whole ==
                  Approx(mean).epsilon(0.015));
            CHECK(mean_square(excitation_of(timeline_of(bundle)), focus) / whole == Approx(mean).epsilon(0.015));
            // The spectrum of what an image plays has the modulation in it, and its mean.
            const DriveSequence sequence = haptogram::sequence_of(timeline_of(bundle));
            REQUIRE(sequence.periods() == 400);
            double sum = 0.0;
            for (const DriveSequence::Step& step : sequence.steps)
                sum += static_cast<double>(step.periods) / 400.0 *
                       std::norm(pressure(array, sequence.drives[step.set], focus));
            CHECK(sum / whole == Approx(mean).epsilon(0.015));
        }
    // Silence of the sequence, on a board without modulation.
    Path halved{{{{{focus}}, 30}, {{}, 30}}, {}};
    const Core plain = find_configuration("tile-100");
    const Bundle half = compile(halved, array, plain).bundle;
    CHECK(mean_square(excitation_of(timeline_of(half)), focus) / whole == Approx(0.5).epsilon(0.01));
}

TEST_CASE("feel: measured pulses give what the image gives", "[feel]") {
    Path path;
    path.steps = {{{{from_mm(-15, 0, 140)}}, 30}, {{{from_mm(15, 0, 140), 0.6}}, 20}, {{}, 10}};
    const Array array = find_array("tile-10x10");
    const Compiled compiled = compile(path, array, core_of_array("tile-10x10"));
    const Bundle& bundle = compiled.bundle;
    // Pulses by hand, as the core would play the image: four passes from clock 777 on, the last of
    // which ends in silence and so is not whole.
    std::vector<Pulse> pulses;
    std::uint64_t at = 777;
    for (int pass = 0; pass < 4; ++pass)
        for (const SequenceEntry& entry : bundle.image.sequence)
            for (int i = 0; i < entry.dwell; ++i, at += bundle.manifest.timer.cycle_clocks()) {
                if (entry.index == 0) continue;
                const Record& record = bundle.image.records[entry.index - 1U];
                for (std::uint32_t channel = 0; channel < bundle.image.channels; ++channel) {
                    const std::uint64_t rise = at + std::uint64_t{record.timings[channel]} * record.prescaler;
                    pulses.push_back(
                        {rise, rise + std::uint64_t{record.pulse_length} * record.prescaler, channel, entry.index});
                }
            }
    const DriveSequence image = haptogram::sequence_of(timeline_of(bundle));
    const DriveSequence measured = haptogram::sequence_of(timeline_of(bundle.manifest, pulses, "pulses.csv"));
    REQUIRE(image.periods() == 60);
    REQUIRE(measured.repeats);
    REQUIRE(measured.periods() == 120);
    // A pulse that rises late in its period may be counted to the next, so what is compared are means and lines.
    const SkinPlace place{from_mm(-15, 0, 140)};
    const auto lines = [&](const DriveSequence& sequence) {
        return lines_of(force_on_skin(array, sequence, place).force_n, sequence.carrier_hz);
    };
    const std::vector<Line> expected = lines(image), found = lines(measured);
    for (std::size_t k = 0; k < 5; ++k) {
        INFO("line " << k);
        CHECK(found[2 * k].hz == Approx(expected[k].hz));
        CHECK(found[2 * k].amplitude == Approx(expected[k].amplitude).epsilon(0.03).margin(1e-6));
    }
    CHECK(places_of(bundle.manifest, image).steps.size() == 3);
    std::vector<Pulse> foreign = {pulses.front()};
    foreign[0].channel = 100;
    CHECK_REFUSED(timeline_of(bundle.manifest, foreign, "pulses.csv"));
    foreign[0] = pulses.front();
    foreign[0].index = 9;
    CHECK_REFUSED(timeline_of(bundle.manifest, foreign, "pulses.csv"));
    CHECK_REFUSED(timeline_of(bundle.manifest, std::vector<Pulse>(), "pulses.csv"));
    CHECK_FALSE(
        haptogram::sequence_of(timeline_of(bundle.manifest, {pulses.begin(), pulses.begin() + 3000}, "pulses.csv"))
            .repeats);
}
