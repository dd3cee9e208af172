// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/spectrum.hpp"

#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace haptogram::perception {
namespace {

using Complex = std::complex<double>;

/// Σ samples[n]·e^{−2πjkn/N} for all k, by Bluestein's chirp: with kn = (k² + n² − (k − n)²)/2 the sum is a
/// convolution, which transforms of a power of two do. So every number of samples takes about as long.
std::vector<Complex> transformed(std::span<const double> samples) {
    const std::size_t count = samples.size(), padded = std::bit_ceil(2 * count);
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
