// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/sound.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram::perception {
namespace {

using std::numbers::pi;

constexpr double lowest_hz = 20.0, highest_hz = 16e3, reference_hz = 200.0;

/// The A-weighted second derivative of a line of E².
double heard(const Line& line) {
    const double omega = 2.0 * pi * line.hz;
    return line.amplitude * omega * omega * a_weighting(line.hz);
}

/// The reference's sum of squares: the square of ½ + ½·sin is ⅜ + ½·sin − ⅛·cos of twice the frequency.
double reference(const Array& array) {
    const double full =
        array.transducer.source_pa_m * array.transducer.source_pa_m * static_cast<double>(array.elements.size());
    const double first = heard({reference_hz, full / 2.0}), second = heard({2.0 * reference_hz, full / 8.0});
    return first * first + second * second;
}

double largest_step(const DriveSequence& sequence) {
    double largest = 0.0;
    std::set<std::pair<std::size_t, std::size_t>> seen;
    for (std::size_t i = sequence.repeats ? 0 : 1; i < sequence.steps.size(); ++i) {
        const std::pair sets(sequence.steps[i == 0 ? sequence.steps.size() - 1 : i - 1].set, sequence.steps[i].set);
        if (!seen.insert(sets).second) continue;
        const auto& before = sequence.drives[sets.first];
        const auto& now = sequence.drives[sets.second];
        for (std::size_t m = 0; m < now.size(); ++m)
            if (now[m] != 0.0 && before[m] != 0.0)
                largest = std::max(largest, std::abs(std::arg(now[m] * std::conj(before[m]))));
    }
    return largest * 180.0 / pi;
}

/// Each set of drives with the time that it plays.
std::vector<WeightedDrives> weighted(const DriveSequence& sequence) {
    std::vector<WeightedDrives> found;
    for (const auto& drives : sequence.drives) found.push_back({0.0, drives});
    for (const DriveSequence::Step& step : sequence.steps) found[step.set].weight += static_cast<double>(step.periods);
    std::erase_if(found, [](const WeightedDrives& one) { return one.weight == 0.0; });
    return found;
}

double level_of(double mean_square) { return sound_level_db(std::sqrt(2.0 * mean_square)); }

}  // namespace

Noise noise_of(const Array& array, const DriveSequence& sequence) {
    const std::uint64_t periods = sequence.periods();
    if (periods == 0) throw bad_input("sequence", "nothing is played; there is nothing to hear");
    std::vector<double> squares(periods);
    // Several elements at a time, which the processor does in about the time of one.
    constexpr std::size_t at_once = 8;
    using Some = Eigen::Array<double, 2 * at_once, 1>;
    for (std::size_t first = 0; first < array.elements.size(); first += at_once) {
        std::vector<Some> wanted(sequence.drives.size(), Some::Zero());
        for (std::size_t set = 0; set < wanted.size(); ++set)
            for (std::size_t i = 0; i < at_once && first + i < array.elements.size(); ++i) {
                const std::complex<double> radiated =
                    sequence.drives[set][first + i] * array.elements[first + i].response;
                wanted[set][static_cast<Eigen::Index>(2 * i)] = radiated.real();
                wanted[set][static_cast<Eigen::Index>(2 * i + 1)] = radiated.imag();
            }
        follow(sequence, array.transducer.bandwidth_hz, wanted,
               [&](std::uint64_t period, const Some& carriers) { squares[period] += carriers.square().sum(); });
    }
    Noise noise;
    noise.largest_step_deg = largest_step(sequence);
    double power = 0.0, strongest = 0.0, mean = 0.0;
    for (Line line : lines_of(squares, sequence.carrier_hz)) {
        if (line.hz == 0.0) mean = line.amplitude;
        // What rounding leaves of a steady drive is no sound.
        if (line.hz < lowest_hz || line.hz > highest_hz || line.amplitude < 1e-12 * mean) continue;
        line.amplitude = heard(line);
        power += line.amplitude * line.amplitude;
        if (line.amplitude > strongest) {
            strongest = line.amplitude;
            noise.loudest_hz = line.hz;
        }
        noise.lines.push_back(line);
    }
    const double unit = std::sqrt(reference(array));
    for (Line& line : noise.lines) line.amplitude /= unit;
    noise.relative_db =
        power > 0.0 ? 10.0 * std::log10(power) - 20.0 * std::log10(unit) : -std::numeric_limits<double>::infinity();
    return noise;
}

std::vector<Exposure> exposure(const Array& array, const DriveSequence& sequence, std::span<const Vec3> ears) {
    const std::vector<WeightedDrives> sets = weighted(sequence);
    const std::vector<float> means = mean_square_pressure_at(array, sets, ears);
    std::vector<float> most(ears.size());
    for (const WeightedDrives& one : sets) {
        const std::vector<float> alone = mean_square_pressure_at(array, {&one, 1}, ears);
        for (std::size_t i = 0; i < most.size(); ++i) most[i] = std::max(most[i], alone[i]);
    }
    std::vector<Exposure> found;
    for (std::size_t i = 0; i < ears.size(); ++i)
        found.push_back({ears[i], level_of(static_cast<double>(means[i])), level_of(static_cast<double>(most[i]))});
    return found;
}

Exposure loudest_around(const Array& array, const DriveSequence& sequence, double radius_m) {
    constexpr int apart_deg = 2;
    std::vector<Vec3> points{{0.0, 0.0, radius_m}};
    for (int tilt = apart_deg; tilt <= 90; tilt += apart_deg)
        for (int turn = 0; turn < 360; turn += apart_deg) {
            const double a = tilt * pi / 180.0, b = turn * pi / 180.0;
            points.push_back(
                {radius_m * std::sin(a) * std::cos(b), radius_m * std::sin(a) * std::sin(b), radius_m * std::cos(a)});
        }
    FieldOptions options;
    options.threads = 0;
    const std::vector<float> means = mean_square_pressure_at(array, weighted(sequence), points, options);
    const auto at = static_cast<std::size_t>(std::max_element(means.begin(), means.end()) - means.begin());
    return exposure(array, sequence, {&points[at], 1}).front();
}

}  // namespace haptogram::perception
