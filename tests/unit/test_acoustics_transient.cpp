// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/transient.hpp"
#include "haptogram/base/error.hpp"

using namespace haptogram;
using std::numbers::pi;

namespace {

using Complex = std::complex<double>;
using Train = std::vector<DrivePulse>;

constexpr double carrier = 40e3;
constexpr double period = 1.0 / carrier;
constexpr double omega = 2.0 * pi * carrier;

Train train(std::size_t periods, double rise, double duty = 0.5) {
    Train pulses;
    for (std::size_t i = 0; i < periods; ++i) {
        const double at = static_cast<double>(i) * period + rise;
        pulses.push_back({at, at + duty * period});
    }
    return pulses;
}

/// Runge and Kutta's fourth order on x' = f(x, u), samples at every `step`, `inner` steps between; the pulses' edges
/// must lie on those steps.
template <std::size_t N, class Derivative>
std::vector<double> integrate(Derivative f, const Train& pulses, double step, std::size_t count, int inner) {
    using State = std::array<double, N>;
    const auto moved = [](State x, const State& d, double h) {
        for (std::size_t i = 0; i < N; ++i) x[i] += h * d[i];
        return x;
    };
    State x{};
    std::vector<double> found;
    const double h = step / inner;
    for (std::size_t i = 0; i < count; ++i) {
        found.push_back(x[0]);
        for (int j = 0; j < inner; ++j) {
            const double middle = (static_cast<double>(i) + (j + 0.5) / inner) * step;
            const bool high = std::any_of(pulses.begin(), pulses.end(),
                                          [&](const DrivePulse& p) { return p.rise_s < middle && middle < p.fall_s; });
            const double u = high ? 1.0 : 0.0;
            const State a = f(x, u);
            const State b = f(moved(x, a, h / 2), u);
            const State c = f(moved(x, b, h / 2), u);
            const State d = f(moved(x, c, h), u);
            for (std::size_t n = 0; n < N; ++n) x[n] += h / 6 * (a[n] + 2 * b[n] + 2 * c[n] + d[n]);
        }
    }
    return found;
}

/// An array whose speed of sound is the reference's.
Array tile() {
    Array array = find_array("tile-10x10");
    array.medium.speed_m_s = 340.0;
    return array;
}

}  // namespace

TEST_CASE("transient: the exact update against Runge and Kutta", "[transient]") {
    // Uneven pulses, one longer than a period, on a grid of 1/40 period.
    const double grid = period / 40;
    const Train pulses = {
        {3 * grid, 20 * grid}, {41 * grid, 61 * grid}, {70 * grid, 133 * grid}, {150 * grid, 151 * grid}};
    const Sampling sampling{0.0, grid, 400};
    SECTION("second order") {
        const double gamma = pi * 2000.0;
        const auto expected = integrate<2>(
            [&](const std::array<double, 2>& x, double u) {  // i' = −ω₀²q − 2γi + 2γu, q' = i
                return std::array<double, 2>{-omega * omega * x[1] - 2 * gamma * x[0] + 2 * gamma * u, x[0]};
            },
            pulses, grid, sampling.count, 8);
        const auto found = output(second_order(carrier, 2000.0), pulses, sampling);
        for (std::size_t i = 0; i < found.size(); ++i)
            REQUIRE(found[i] == Approx(expected[i] * pi / 2).margin(1e-6));  // a 50 % train has a fundamental of 2/π
    }
    SECTION("Butterworth and Van Dyke's circuit") {
        const ButterworthVanDyke c;
        const auto f = [&](const std::array<double, 3>& x, double u) {  // current, voltage on C, voltage on C_p
            return std::array<double, 3>{(x[2] - c.resistance_ohm * x[0] - x[1]) / c.inductance_h,
                                         x[0] / c.capacitance_f, ((u - x[2]) / c.driver_ohm - x[0]) / c.parallel_f};
        };
        const auto expected = integrate<3>(f, pulses, grid, sampling.count, 32);
        const Resonator circuit = butterworth_van_dyke(c);
        const auto found = output(circuit, pulses, sampling);
        // The gain at the series resonance, from the impedances: the branch is R there.
        const double w = 2 * pi * circuit.peak_hz;
        const Complex both = 1.0 / (1.0 / c.resistance_ohm + Complex(0, w * c.parallel_f));
        const double gain = std::abs(both / (both + c.driver_ohm)) / c.resistance_ohm;
        for (std::size_t i = 0; i < found.size(); ++i)
            REQUIRE(found[i] == Approx(expected[i] / gain * pi / 2).margin(1e-5));
    }
}

TEST_CASE("transient: constants of the resonators", "[transient]") {
    const Resonator hoshi = second_order(carrier, 2000.0);
    REQUIRE(hoshi.time_constant_s() == Approx(159e-6).margin(0.5e-6));
    REQUIRE(std::log(10.0) * hoshi.time_constant_s() == Approx(366e-6).margin(0.6e-6));
    REQUIRE(std::abs(hoshi.response(carrier) - 1.0) < 1e-12);
    REQUIRE(std::abs(hoshi.response(0.0)) < 1e-12);
    // Half power at two frequencies, 2 kHz apart, whose geometric mean is the resonance.
    const double high = 1e3 + std::sqrt(1e6 + carrier * carrier);
    REQUIRE(std::norm(hoshi.response(high)) == Approx(0.5).epsilon(1e-9));
    REQUIRE(std::norm(hoshi.response(high - 2e3)) == Approx(0.5).epsilon(1e-9));
    // AUTD3's circuit: 39.79 kHz, Q 23.5, τ 0.19 ms; C_p shifts the pole by the last digit.
    const Resonator circuit = butterworth_van_dyke();
    REQUIRE(circuit.peak_hz == Approx(39.79e3).margin(5));
    REQUIRE(circuit.time_constant_s() == Approx(0.19e-3).margin(0.005e-3));
    REQUIRE(pi * circuit.peak_hz * circuit.time_constant_s() == Approx(23.5).margin(0.1));
    REQUIRE(std::abs(circuit.response(circuit.peak_hz)) == Approx(1.0));
    for (const auto& [resonance, bandwidth] : {std::pair{40e3, 0.0}, {40e3, -1.0}, {40e3, 80e3}, {0.0, 1.0}})
        REQUIRE_THROWS_AS(second_order(resonance, bandwidth), Error);
}

TEST_CASE("transient: the steady state of a resonator is the phasor's", "[transient]") {
    const Resonator resonator =
        GENERATE(second_order(carrier, 2000.0), second_order(39.2e3, 1200.0), butterworth_van_dyke());
    const double duty = GENERATE(0.5, 0.25, 0.1);
    const double rise = 7.3e-6;
    const auto periods = static_cast<std::size_t>(std::ceil(15 * resonator.time_constant_s() / period));
    const Train pulses = train(periods + 4, rise, duty);
    const auto samples = output(resonator, pulses, {static_cast<double>(periods) * period, period / 64, 193});
    const Complex found = envelope(samples, 64)[96];
    const Complex expected = carrier_component(train(1, rise, duty), carrier, period) * resonator.response(carrier);
    REQUIRE(std::abs(found - expected) < 1e-3 * std::abs(expected));
}

TEST_CASE("transient: the array's steady pressure is the field's, at the focus and beside it", "[transient]") {
    Array array = find_array(GENERATE("tile-10x10", "hoshi-18x18"));
    array.duty = GENERATE(0.5, 0.3);
    array.medium.absorption_np_m = 0.1;
    const Vec3 focus = from_mm(12, -7, 110);
    const Resonator resonator = second_order(array);
    const std::size_t wait = 130;
    const auto trains = focal_trains(array, focus, 0, wait + 5);
    std::vector<Complex> drives;
    drives.reserve(trains.size());
    for (const Train& pulses : trains)
        drives.push_back(array.transducer.source_pa_m *
                         carrier_component(std::span(pulses.data(), 1), carrier, period));
    const double full = std::abs(pressure(array, ideal_drives(array, focus), focus));
    for (const Vec3 point : {focus, from_mm(14, -4, 113), from_mm(40, 20, 90)}) {
        const auto samples =
            pressure_over_time(array, resonator, trains, point, {static_cast<double>(wait) * period, period / 32, 97});
        const Complex found = envelope(samples, 32)[48];
        REQUIRE(std::abs(found - pressure(array, drives, point)) < 1e-3 * full);
        if (point == focus) REQUIRE(std::abs(found) == Approx(full * std::sin(pi * array.duty)).epsilon(1e-3));
    }
}

TEST_CASE("transient: ring-up and decay are 1 − e^(−t/τ) and e^(−t/τ)", "[transient]") {
    // A train from 0 differs from a modulated sine by its mean, whose step has 1/Q of the amplitude.
    const double bandwidth = GENERATE(20.0, 200.0, 2000.0);
    const Resonator resonator = second_order(carrier, bandwidth);
    const double tau = 1.0 / (pi * bandwidth);
    const double tolerance = 1.1 * bandwidth / carrier;
    const auto periods = static_cast<std::size_t>(std::round(5.0 * tau / period));
    const auto samples = output(resonator, train(periods, 0.0), {0.0, period / 32, std::size_t{64} * periods});
    const auto envelopes = envelope(samples, 32);
    const double stop = static_cast<double>(periods) * period;
    for (std::size_t i = 16; i + 16 < samples.size(); ++i) {
        const double t = static_cast<double>(i) * period / 32;
        const double up = 1.0 - std::exp(-t / tau);
        if (t < stop - period) REQUIRE(std::abs(std::abs(envelopes[i]) - up) < tolerance * std::exp(-t / tau) + 1e-4);
        if (t > stop + period) {
            const double reached = 1.0 - std::exp(-stop / tau);
            REQUIRE(std::abs(envelopes[i]) == Approx(reached * std::exp(-(t - stop) / tau)).epsilon(1.1 * tolerance));
        }
    }
}

TEST_CASE("transient: rise times: Hoshi's 0.5 ms, and a focus 10 cm above the tile", "[transient]") {
    const Array array = tile();
    const Resonator resonator = second_order(array);
    const RingUp up = ring_up(array, resonator, from_mm(0, 0, 100));
    REQUIRE(up.flight_spread_s == Approx(53.8e-6).margin(0.05e-6));
    // One element: 366 µs for a modulated sine; a train from 0 starts with its mean's step, 1/Q of the amplitude.
    REQUIRE(up.ring_up_s == Approx(366e-6).margin(9e-6));
    // Together: later than one element, sooner than the last to arrive.
    REQUIRE(up.rise_s > up.ring_up_s);
    REQUIRE(up.rise_s < up.ring_up_s + up.flight_spread_s + period);
    // The number that acoustics/README.md and the figures tell is of the shipped array, in air of 20 °C.
    const Array shipped = find_array("tile-10x10");
    const RingUp told = ring_up(shipped, second_order(shipped), from_mm(0, 0, 100));
    REQUIRE(told.rise_s == Approx(394e-6).margin(0.5e-6));
    REQUIRE(told.flight_spread_s == Approx(53.3e-6).margin(0.05e-6));
    REQUIRE(told.ring_up_s == Approx(358e-6).margin(0.5e-6));
    // Within Hoshi's 0.5 ms the amplitude is at 1 − e^(−π) = 95.7 %.
    const RingUp hoshi = ring_up(array, resonator, from_mm(0, 0, 100), 1.0 - std::exp(-pi));
    REQUIRE(hoshi.ring_up_s == Approx(0.5e-3).margin(9e-6));
    // As the envelope of an independent sum: each element's 1 − e^(−t/τ) from its arrival.
    const Vec3 focus = from_mm(0, 0, 100);
    double t = 0.0;
    const auto reached = [&] {
        double sum = 0.0;
        double full = 0.0;
        for (const Element& e : array.elements) {
            const double range = distance(e, focus);
            const double late = (range - distance(array.elements[44], focus)) / 340.0;
            const double weight =
                piston_directivity(omega / 340.0 * 4.5e-3 * std::hypot(e.position.x, e.position.y) / range) / range;
            full += weight;
            if (t > late) sum += weight * (1.0 - std::exp(-(t - late) * pi * 2000.0));
        }
        return sum / full;
    };
    while (reached() < 0.9) t += 1e-7;
    CAPTURE(t, up.rise_s);
    REQUIRE(up.rise_s == Approx(t).margin(period / 2 + 9e-6));  // trains start half a period apart at most
}

TEST_CASE("transient: what alternating between two foci keeps", "[transient]") {
    const Array array = tile();
    const Resonator resonator = second_order(array);
    const Vec3 focus = from_mm(-25, 0, 130);
    const Vec3 other = from_mm(25, 0, 130);
    const std::size_t periods = GENERATE(1, 4, 26, 40);
    const Alternation found = alternate(array, resonator, focus, other, periods);
    // Each element's phasor goes between two drives as e^(−t/τ), periodically, and arrives R/c later.
    const double slot = static_cast<double>(periods) * period;
    const double tau = resonator.time_constant_s();
    const auto here = ideal_drives(array, focus);
    const auto there = ideal_drives(array, other);
    const double full = std::abs(pressure(array, here, focus));
    double peak = 0.0;
    double power = 0.0;
    constexpr int steps = 800;
    for (int i = 0; i < steps; ++i) {
        Complex sum = 0.0;
        for (std::size_t m = 0; m < here.size(); ++m) {
            const double emitted = 2 * slot * i / steps - distance(array.elements[m], focus) / 340.0;
            const double phase = emitted - 2 * slot * std::floor(emitted / (2 * slot));
            const Complex goal = phase < slot ? here[m] : there[m];
            const Complex before = phase < slot ? there[m] : here[m];
            const double left = std::exp(-std::fmod(phase, slot) / tau) / (1.0 + std::exp(-slot / tau));
            sum += (goal + (before - goal) * left) * propagation(array, array.elements[m], focus);
        }
        peak = std::max(peak, std::abs(sum) / full);
        power += std::norm(sum) / (full * full) / steps;
    }
    CAPTURE(periods, found.peak, found.power);
    // Phasors know neither where in its period a pulse begins nor that pulses merge, which matters in slots of one.
    REQUIRE(found.peak == Approx(peak).margin(periods == 1 ? 0.05 : 0.02));
    REQUIRE(found.power == Approx(power).margin(periods == 1 ? 0.05 : 0.02));
    REQUIRE_THROWS_AS(alternate(array, resonator, focus, other, 0), Error);
}

TEST_CASE("transient: alternating with itself keeps everything, sooner than slower", "[transient]") {
    const Array array = tile();
    const Resonator resonator = GENERATE(second_order(carrier, 2000.0), butterworth_van_dyke());
    const Vec3 focus = from_mm(0, 0, 100);
    const Alternation same = alternate(array, resonator, focus, focus, 4);
    REQUIRE(same.peak == Approx(1.0).epsilon(1e-9));
    REQUIRE(same.power == Approx(1.0).epsilon(1e-9));
    double before = 0.0;
    for (const std::size_t periods : std::initializer_list<std::size_t>{1, 4, 26, 40, 200}) {
        const double peak = alternate(array, resonator, focus, from_mm(30, 0, 100), periods).peak;
        REQUIRE(peak > before);
        before = peak;
    }
    REQUIRE(before == Approx(1.0).margin(1e-3));
}

TEST_CASE("transient: silence before the wave arrives, a train for every element", "[transient]") {
    const Array array = tile();
    const Vec3 focus = from_mm(0, 0, 100);
    const auto trains = focal_trains(array, focus, 0, 10);
    for (const Train& pulses : trains) {
        REQUIRE(pulses.size() == 10);
        REQUIRE(pulses.front().rise_s >= 0.0);
        REQUIRE(pulses.front().rise_s < period);
    }
    const auto samples = pressure_over_time(array, second_order(array), trains, focus, {0.0, 1e-6, 400});
    for (std::size_t i = 0; i < 293; ++i) REQUIRE(samples[i] == 0.0);  // 99.8 mm to the nearest, 293 µs
    REQUIRE(*std::max_element(samples.begin(), samples.end()) > 10.0);
    REQUIRE_THROWS_AS(pressure_over_time(array, second_order(array), {}, focus, {0.0, 1e-6, 4}), Error);
    REQUIRE_THROWS_AS(
        pressure_over_time(array, second_order(array), trains, array.elements[5].position, {0.0, 1e-6, 4}), Error);
    REQUIRE(output(second_order(array), {}, {0.0, 1e-6, 3}) == std::vector<double>(3));
    REQUIRE(envelope(std::vector<double>(8), 8) == std::vector<Complex>(8));
}
