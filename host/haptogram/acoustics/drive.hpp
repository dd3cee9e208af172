// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <span>

namespace haptogram {

/// A pulse on one channel: when it rises and when it falls, seconds.
struct DrivePulse {
    double rise_s;
    double fall_s;
};

/// The carrier's complex amplitude in a train of pulses of height 1 that lasts `duration_s`: the Fourier component
/// 2/T ∫ s(t)·e^{−jωt} dt, divided by 2/π. With this scale a train of 50 % duty has amplitude 1, and one of any duty
/// sin(π·duty) (Hoshi eq. 7). The phase is −ω times the delay of the pulses' middle.
[[nodiscard]] std::complex<double> carrier_component(std::span<const DrivePulse> pulses, double carrier_hz,
                                                     double duration_s);

}  // namespace haptogram
