// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <span>

namespace haptogram {

/// A pulse on one channel, seconds.
struct DrivePulse {
    double rise_s;
    double fall_s;
};

/// The carrier in a pulse train, as a spectrum analyser would find it over a time of `duration_s`: the Fourier
/// component 2/T ∫ s(t)·e^{−jωt} dt of the unit pulses, divided by 2/π, so that a train of 50 % duty has amplitude 1
/// (Hoshi eq. 7: sin(π·duty)). Its phase is −ω times the delay of the pulses' middle.
[[nodiscard]] std::complex<double> carrier_component(std::span<const DrivePulse> pulses, double carrier_hz,
                                                     double duration_s);

}  // namespace haptogram
