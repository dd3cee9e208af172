// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

namespace haptogram::perception {

/// A sinusoidal part of a signal that repeats.
struct Line {
    double hz = 0.0;
    double amplitude = 0.0;  ///< peak value, in the signal's unit
};

/// The lines of a signal that repeats, from 0 Hz, its mean, up to half the sampling rate: those of the discrete Fourier
/// transform, rate/n apart for n samples. A line is A·cos(2πft + φ).
/// @param rate_hz  of the samples
[[nodiscard]] std::vector<Line> lines_of(std::span<const double> samples, double rate_hz);

/// The A-weighting of IEC 61672-1, as a factor on an amplitude: 1 at 1 kHz.
[[nodiscard]] double a_weighting(double hz);

}  // namespace haptogram::perception
