// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/felt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "haptogram/perception/magnitude.hpp"

namespace haptogram::perception {

std::array<unsigned, 2> strength_steps(double over_db) {
    constexpr double most_db = 2.98, least_db = 1.65;
    const auto steps = [over_db](double step_db) {
        return static_cast<unsigned>(std::floor(std::max(0.0, over_db) / step_db));
    };
    return {steps(most_db), steps(least_db)};
}

std::optional<std::array<double, 2>> next_frequency_hz(double hz) {
    constexpr double lowest_hz = 2.0, highest_hz = 300.0, least = 0.13, most = 0.38;
    if (!(hz >= lowest_hz && hz <= highest_hz)) return std::nullopt;
    return std::array<double, 2>{hz * (1.0 + least), hz * (1.0 + most)};
}

namespace {

using Complex = std::complex<double>;

/// The next number that has no factors but 2, 3 and 5.
std::size_t without_large_factors(std::size_t least) {
    std::size_t best = SIZE_MAX;
    for (std::size_t fives = 1; fives < 5 * least; fives *= 5)
        for (std::size_t threes = fives; threes < 3 * least; threes *= 3) {
            std::size_t number = threes;
            while (number < least) number *= 2;
            best = std::min(best, number);
        }
    return best;
}

/// Σ samples[n]·e^{−2πjkn/N} for all k, by Bluestein's chirp: with kn = (k² + n² − (k − n)²)/2 the sum is a
/// convolution, which transforms of numbers without large factors do. So every number of samples takes about as long.
std::vector<Complex> transformed(std::span<const Complex> samples) {
    const std::size_t count = samples.size(), padded = without_large_factors(2 * count);
    std::vector<Complex> chirp(count), signal(padded), kernel(padded), a, b;
    for (std::size_t n = 0; n < count; ++n) {
        // n² modulo 2N, so that the angle stays small and exact.
        const auto square = static_cast<double>(std::uint64_t{n} * n % (2 * std::uint64_t{count}));
        chirp[n] = std::polar(1.0, -std::numbers::pi * square / static_cast<double>(count));
        signal[n] = samples[n] * chirp[n];
        kernel[n] = std::conj(chirp[n]);
        if (n > 0) kernel[padded - n] = kernel[n];
    }
    Eigen::FFT<double> fft;
    fft.fwd(a, signal);
    fft.fwd(b, kernel);
    for (std::size_t k = 0; k < padded; ++k) a[k] *= b[k];
    fft.inv(b, a);
    b.resize(count);
    for (std::size_t k = 0; k < count; ++k) b[k] *= chirp[k];
    return b;
}

/// The same of real samples, for k ≤ N/2. An even number of them goes in as half as many complex ones.
std::vector<Complex> transformed(std::span<const double> samples) {
    if (samples.size() % 2 != 0) return transformed(std::vector<Complex>(samples.begin(), samples.end()));
    const std::size_t half = samples.size() / 2;
    std::vector<Complex> pairs(half), found(half + 1);
    for (std::size_t n = 0; n < half; ++n) pairs[n] = {samples[2 * n], samples[2 * n + 1]};
    const std::vector<Complex> sums = transformed(pairs);
    for (std::size_t k = 0; k <= half; ++k) {
        const Complex here = sums[k % half], mirrored = std::conj(sums[(half - k) % half]);
        const Complex turn =
            std::polar(0.5, -std::numbers::pi * (static_cast<double>(k) / static_cast<double>(half) + 0.5));
        found[k] = 0.5 * (here + mirrored) + turn * (here - mirrored);
    }
    return found;
}

}  // namespace

std::vector<Line> lines_of(std::span<const double> samples, double rate_hz) {
    std::vector<Line> lines;
    if (samples.empty()) return lines;
    const std::vector<Complex> sums = transformed(samples);
    const auto count = static_cast<double>(samples.size());
    for (std::size_t k = 0; 2 * k <= samples.size(); ++k) {
        const double once = k == 0 || 2 * k == samples.size() ? 1.0 : 2.0;
        lines.push_back({static_cast<double>(k) * rate_hz / count, once * std::abs(sums[k]) / count});
    }
    return lines;
}

double a_weighting(double hz) {
    // The poles and the value at 1 kHz that the standard gives.
    const auto response = [](double f) {
        const double s = f * f;
        return 12194.0 * 12194.0 * s * s /
               ((s + 20.6 * 20.6) * std::sqrt((s + 107.7 * 107.7) * (s + 737.9 * 737.9)) * (s + 12194.0 * 12194.0));
    };
    return response(hz) / response(1000.0);
}

namespace {

/// The part at the frequency of modulation over the mean, of the square wave that the tables belong to.
double fundamental_over_mean() { return fundamental_output(Waveform::square) / mean_output(Waveform::square); }

}  // namespace

const char* name_of(Basis basis) {
    switch (basis) {
        case Basis::tables: return "tables";
        case Basis::displacement: return "displacement";
        case Basis::none: return "none";
    }
    return "none";
}

LeastForce least_vibration(const Tables& tables, Region region, double hz, double grip_n) {
    const double first_hz = tables.fits.front().frequency_hz, last_hz = tables.fits.back().frequency_hz;
    const double inside_hz = std::clamp(hz, first_hz, last_hz);
    const double force_n = least_felt_gf(tables, region, inside_hz, grip_n) * gram_force_n * fundamental_over_mean();
    if (hz == inside_hz) return {force_n, Basis::tables};
    if (!(hz >= lowest_vibration_hz && hz <= highest_vibration_hz)) return {};
    const double db = least_displacement_db(hz) - least_displacement_db(inside_hz);
    return {force_n * std::pow(10.0, db / 20.0), Basis::displacement};
}

Felt felt_of(std::span<const Line> spectrum, const Tables& tables, Region region, double grip_n,
             std::size_t most_lines) {
    Felt felt;
    double power = 0.0;  // of the lines that one channel sums
    for (const Line& line : spectrum) {
        if (line.hz < lowest_vibration_hz || line.hz > highest_vibration_hz || !(line.amplitude > 0.0)) continue;
        const LeastForce least = least_vibration(tables, region, line.hz, grip_n);
        felt.lines.push_back(
            {line.hz, line.amplitude, least.force_n, 20.0 * std::log10(line.amplitude / least.force_n), least.basis});
        const double ratio = line.amplitude / least.force_n;
        if (line.hz >= pacinian_from_hz)
            power += ratio * ratio;
        else
            felt.over_db = std::max(felt.over_db, felt.lines.back().over_db);
    }
    if (power > 0.0) felt.over_db = std::max(felt.over_db, 10.0 * std::log10(power));
    std::stable_sort(felt.lines.begin(), felt.lines.end(),
                     [](const FeltLine& a, const FeltLine& b) { return a.over_db > b.over_db; });
    const auto known = std::find_if(felt.lines.begin(), felt.lines.end(),
                                    [](const FeltLine& line) { return line.basis == Basis::tables; });
    if (region != Region::palm)
        felt.no_magnitude = "magnitudes are known of palms alone";
    else if (known == felt.lines.end())
        felt.no_magnitude = fmt::format("nothing alternates between {:g} and {:g} Hz, which the tables cover",
                                        tables.fits.front().frequency_hz, tables.fits.back().frequency_hz);
    else if (known->over_db < 0.0)
        felt.no_magnitude =
            fmt::format("the strongest line that the tables cover, at {:.4g} Hz, is below the threshold", known->hz);
    else {
        const FrequencyFit fit = fit_at(tables, known->hz);
        const double gf = known->force_n / gram_force_n / fundamental_over_mean();
        if (gf > full_output_gf(fit))
            felt.no_magnitude =
                fmt::format("an output of {:.3f} gf at {:.4g} Hz is more than the {:.3f} gf that the tables end with",
                            gf, known->hz, full_output_gf(fit));
        else
            felt.magnitude = magnitude_of_output(fit, gf);
    }
    felt.lines.resize(std::min(felt.lines.size(), most_lines));
    return felt;
}

}  // namespace haptogram::perception
