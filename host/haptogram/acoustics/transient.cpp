// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/transient.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

using Complex = std::complex<double>;
constexpr double pi = std::numbers::pi;

/// Samples in a carrier period where envelopes are measured. Only the 31st harmonic and higher ones disturb them.
constexpr std::size_t fine = 32;

/// A mode's contribution to the output: its state with, for a complex pole, that of the conjugate pole.
double share(const Resonator::Mode& mode, Complex state) {
    return mode.pole.imag() == 0.0 ? state.real() : 2.0 * state.real();
}

/// H(jω).
Complex transfer(const std::vector<Resonator::Mode>& modes, double frequency_hz) {
    const Complex s(0.0, 2.0 * pi * frequency_hz);
    Complex sum = 0.0;
    for (const auto& mode : modes) {
        sum += mode.residue / (s - mode.pole);
        if (mode.pole.imag() != 0.0) sum += std::conj(mode.residue) / (s - std::conj(mode.pole));
    }
    return sum;
}

/// Scales the residues so that a 50 % train of 0 and 1, whose fundamental is 2/π, gives amplitude 1 at the peak.
void normalise(Resonator& resonator) {
    const double gain = std::abs(transfer(resonator.modes, resonator.peak_hz)) * 2.0 / pi;
    for (auto& mode : resonator.modes) mode.residue /= gain;
}

/// One mode's state, driven by 0 or 1: z' = λz + r·u.
class ModeState {
public:
    explicit ModeState(const Resonator::Mode& mode) : mode_(mode), rest_(-mode.residue / mode.pole) {}

    void advance(double seconds, bool high) {
        if (seconds <= 0.0) return;
        if (seconds != step_s_) {
            step_s_ = seconds;
            factor_ = std::exp(mode_.pole * seconds);
        }
        const Complex goal = high ? rest_ : 0.0;
        const Complex off =
            state_ - goal;  // multiplied by hand, because std::complex checks each product for infinities
        state_ = goal + Complex(off.real() * factor_.real() - off.imag() * factor_.imag(),
                                off.real() * factor_.imag() + off.imag() * factor_.real());
    }

    [[nodiscard]] double value() const { return share(mode_, state_); }

private:
    Resonator::Mode mode_;
    Complex rest_;  ///< the state after the drive has been 1 for long
    Complex state_;
    double step_s_ = 0.0;
    Complex factor_ = 1.0;
};

/// Adds `gain` times the resonator's output to `sum`.
void add_output(const Resonator& resonator, std::span<const DrivePulse> pulses, const Sampling& sampling, double gain,
                std::vector<double>& sum) {
    for (const auto& mode : resonator.modes) {
        ModeState state(mode);
        std::size_t edge = 0;  // the next edge; rises have even numbers, falls odd ones
        const auto time_of = [&](std::size_t e) { return e % 2 == 0 ? pulses[e / 2].rise_s : pulses[e / 2].fall_s; };
        const std::size_t edges = 2 * pulses.size();
        double now = 0.0;
        for (std::size_t i = 0; i < sampling.count; ++i) {
            const double sample_s = sampling.start_s + static_cast<double>(i) * sampling.step_s;
            for (; edge < edges && time_of(edge) <= sample_s; ++edge) {
                if (edge > 0) state.advance(time_of(edge) - now, edge % 2 == 1);
                now = time_of(edge);
            }
            if (edge == 0) continue;  // before the first pulse
            state.advance(sample_s - now, edge % 2 == 1);
            now = sample_s;
            sum[i] += gain * state.value();
        }
    }
}

/// Largest amplitude and mean square amplitude of some envelopes.
struct Level {
    double peak = 0.0;
    double power = 0.0;
};
Level level(std::span<const Complex> envelopes, std::size_t begin, std::size_t end) {
    Level found;
    for (std::size_t i = begin; i < end; ++i) {
        found.peak = std::max(found.peak, std::abs(envelopes[i]));
        found.power += std::norm(envelopes[i]) / static_cast<double>(end - begin);
    }
    return found;
}

/// When the envelope last rises above `goal`, in seconds after the first sample; linear between samples.
double crossing_s(std::span<const Complex> envelopes, double goal, double step_s) {
    std::size_t i = envelopes.size() - fine / 2;
    while (i > 0 && std::abs(envelopes[i - 1]) >= goal) --i;
    if (i == 0) return 0.0;
    const double low = std::abs(envelopes[i - 1]);
    const double high = std::abs(envelopes[i]);
    return (static_cast<double>(i - 1) + (goal - low) / (high - low)) * step_s;
}

}  // namespace

std::complex<double> Resonator::response(double frequency_hz) const { return transfer(modes, frequency_hz) * 2.0 / pi; }

double Resonator::time_constant_s() const {
    double slowest = 0.0;
    for (const Mode& mode : modes) slowest = std::max(slowest, -1.0 / mode.pole.real());
    return slowest;
}

Resonator second_order(double resonance_hz, double bandwidth_hz) {
    if (!(bandwidth_hz > 0.0) || !(bandwidth_hz < 2.0 * resonance_hz))
        throw bad_input("resonator", fmt::format("a bandwidth of {} Hz at {} Hz does not resonate; expected more than "
                                                 "0 and less than twice the resonance",
                                                 bandwidth_hz, resonance_hz));
    const double gamma = pi * bandwidth_hz;
    const double omega = 2.0 * pi * resonance_hz;
    const Complex pole(-gamma, std::sqrt(omega * omega - gamma * gamma));
    Resonator resonator{{{pole, 2.0 * gamma * pole / (pole - std::conj(pole))}}, resonance_hz};
    normalise(resonator);
    return resonator;
}

Resonator second_order(const Array& array) { return second_order(array.carrier_hz, array.transducer.bandwidth_hz); }

Resonator butterworth_van_dyke(const ButterworthVanDyke& circuit) {
    // By Kirchhoff's laws, current over voltage is sC/((s²LC + sRC + 1)(1 + sR_dC_p) + sR_dC). Newton's method finds
    // the complex pair of the denominator's roots; the third root is real.
    const double lc = circuit.inductance_h * circuit.capacitance_f;
    const double rc = circuit.resistance_ohm * circuit.capacitance_f;
    const double lag = circuit.driver_ohm * circuit.parallel_f;
    const double a3 = lc * lag;
    const double a2 = lc + rc * lag;
    const double a1 = rc + lag + circuit.driver_ohm * circuit.capacitance_f;
    const auto slope = [&](Complex s) { return (3.0 * a3 * s + 2.0 * a2) * s + a1; };
    const double omega = 1.0 / std::sqrt(lc);
    Complex pair(-(circuit.resistance_ohm + circuit.driver_ohm) / (2.0 * circuit.inductance_h), omega);
    for (int i = 0; i < 50; ++i) pair -= (((a3 * pair + a2) * pair + a1) * pair + 1.0) / slope(pair);
    const double real = -a2 / a3 - 2.0 * pair.real();  // the roots' sum is −a2/a3
    Resonator resonator{
        {{pair, circuit.capacitance_f * pair / slope(pair)}, {real, circuit.capacitance_f * real / slope(real)}},
        omega / (2.0 * pi)};
    normalise(resonator);
    return resonator;
}

std::vector<double> output(const Resonator& resonator, std::span<const DrivePulse> pulses, const Sampling& sampling) {
    std::vector<double> found(sampling.count);
    add_output(resonator, pulses, sampling, 1.0, found);
    return found;
}

/// How much earlier an element's wave is than its kind's.
static double lead_s(const Array& array, const Element& element) {
    return std::arg(element.response) / (2.0 * pi * array.carrier_hz);
}

std::vector<double> pressure_over_time(const Array& array, const Resonator& resonator,
                                       std::span<const std::vector<DrivePulse>> trains, Vec3 point,
                                       const Sampling& sampling) {
    if (trains.size() != array.elements.size())
        throw bad_input("field", fmt::format("{} pulse trains for {} elements; give one an element", trains.size(),
                                             array.elements.size()));
    const double k = 2.0 * pi / array.wavelength_m();
    std::vector<double> sum(sampling.count);
    for (std::size_t m = 0; m < trains.size(); ++m) {
        const Element& element = array.elements[m];
        const double range = distance(element, point);
        // Delays stand for the phases of propagation() and of the response. Without them propagation() is real, and
        // negative where the directivity is.
        const Complex wave = propagation(array, element, point) * element.aligning() * std::polar(1.0, k * range);
        Sampling earlier = sampling;
        earlier.start_s += lead_s(array, element) - range / array.medium.speed_m_s;
        add_output(resonator, trains[m], earlier, array.transducer.source_pa_m * wave.real(), sum);
    }
    return sum;
}

std::vector<std::complex<double>> envelope(std::span<const double> samples, std::size_t samples_per_period) {
    const std::size_t n = samples_per_period;
    std::vector<Complex> turn;
    for (std::size_t i = 0; i < n; ++i)
        turn.push_back(
            std::polar(2.0 / static_cast<double>(n), -2.0 * pi * static_cast<double>(i) / static_cast<double>(n)));
    std::vector<Complex> found(samples.size());
    if (samples.size() <= n) return found;
    for (std::size_t middle = n / 2; middle + n / 2 < samples.size(); ++middle) {
        const std::size_t begin = middle - n / 2;
        // The trapezoidal rule over one period, in which the first and the last sample count half.
        Complex sum = 0.5 * (samples[begin] + samples[begin + n]) * turn[begin % n];
        for (std::size_t i = 1; i < n; ++i) sum += samples[begin + i] * turn[(begin + i) % n];
        found[middle] = sum;
    }
    return found;
}

std::vector<std::vector<DrivePulse>> focal_trains(const Array& array, Vec3 focus, std::size_t first,
                                                  std::size_t periods) {
    const double period_s = 1.0 / array.carrier_hz;
    std::vector<std::vector<DrivePulse>> trains;
    for (const Element& element : array.elements) {
        const double flight_s = distance(element, focus) / array.medium.speed_m_s;
        // The pulse's middle comes before the start of a period, by the time that its wave takes to the focus.
        const double into = (lead_s(array, element) - flight_s) / period_s - array.duty / 2.0;
        const double rise = (into - std::floor(into)) * period_s;
        auto& train = trains.emplace_back();
        for (std::size_t i = 0; i < periods; ++i) {
            const double at = static_cast<double>(first + i) * period_s + rise;
            train.push_back({at, at + array.duty * period_s});
        }
    }
    return trains;
}

RingUp ring_up(const Array& array, const Resonator& resonator, Vec3 focus, double fraction) {
    const auto range = [&](const Element& a, const Element& b) { return distance(a, focus) < distance(b, focus); };
    const auto [nearest, farthest] = std::minmax_element(array.elements.begin(), array.elements.end(), range);
    RingUp found;
    found.flight_spread_s = (distance(*farthest, focus) - distance(*nearest, focus)) / array.medium.speed_m_s;
    const double period_s = 1.0 / array.carrier_hz;
    constexpr double settled = 20.0;  // time constants: e^−20 is 2e-9
    const double wait_s = settled * resonator.time_constant_s() + found.flight_spread_s;
    const auto periods = static_cast<std::size_t>(std::ceil(wait_s / period_s)) + 3;

    const auto form = [&](const Array& some, double& first_arrival_s) {
        const auto trains = focal_trains(some, focus, 0, periods);
        first_arrival_s = std::numeric_limits<double>::infinity();
        for (std::size_t m = 0; m < trains.size(); ++m)
            first_arrival_s = std::min(
                first_arrival_s, trains[m].front().rise_s + distance(some.elements[m], focus) / some.medium.speed_m_s);
        // Sampling begins one period before the first arrival, so that the first envelope is of silence, and ends
        // before the last pulse.
        const double step_s = period_s / fine;
        const Sampling sampling{first_arrival_s - period_s, step_s, fine * (periods - 1)};
        const auto envelopes = envelope(pressure_over_time(some, resonator, trains, focus, sampling), fine);
        const double steady = std::abs(envelopes[envelopes.size() - fine]);
        return crossing_s(envelopes, fraction * steady, step_s) - period_s;
    };
    Array one = array;
    one.elements = {*nearest};
    double ignored = 0.0;
    found.ring_up_s = form(one, ignored);
    found.rise_s = form(array, found.first_arrival_s);
    return found;
}

Alternation alternate(const Array& array, const Resonator& resonator, Vec3 focus, Vec3 other, std::size_t periods) {
    if (periods == 0) throw bad_input("field", "a focus cannot play for 0 periods; give 1 or more");
    double farthest = 0.0;
    for (const Element& element : array.elements) farthest = std::max(farthest, distance(element, focus));
    const double period_s = 1.0 / array.carrier_hz;
    constexpr double settled = 12.0;  // time constants: e^−12 is 6e-6
    const double wait_s = farthest / array.medium.speed_m_s + settled * resonator.time_constant_s();
    const std::size_t both = 2 * periods;
    const std::size_t before = (static_cast<std::size_t>(std::ceil(wait_s / period_s)) / both + 1) * both;
    const std::size_t total = before + both + 2;

    const auto here = focal_trains(array, focus, 0, total);
    const auto there = focal_trains(array, other, 0, total);
    auto mixed = here;
    for (std::size_t m = 0; m < mixed.size(); ++m)
        for (std::size_t i = 0; i < total; ++i) {
            if (i / periods % 2 == 1) mixed[m][i] = there[m][i];
            // A pulse that has started always completes. If the next one starts before that, the two merge.
            if (i > 0) mixed[m][i].rise_s = std::max(mixed[m][i].rise_s, mixed[m][i - 1].fall_s);
        }
    const Sampling sampling{static_cast<double>(before) * period_s, period_s / fine, fine * (both + 1) + 1};
    const auto measure = [&](const std::vector<std::vector<DrivePulse>>& trains) {
        const auto envelopes = envelope(pressure_over_time(array, resonator, trains, focus, sampling), fine);
        return level(envelopes, fine / 2, fine / 2 + fine * both);
    };
    const Level steady = measure(here);
    const Level found = measure(mixed);
    return {found.peak / steady.peak, found.power / steady.power};
}

}  // namespace haptogram
