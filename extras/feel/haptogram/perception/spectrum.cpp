// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace haptogram::perception {
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

}  // namespace haptogram::perception
