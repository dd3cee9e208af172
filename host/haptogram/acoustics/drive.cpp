// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/drive.hpp"

#include <cmath>
#include <numbers>

namespace haptogram {

std::complex<double> carrier_component(std::span<const DrivePulse> pulses, double carrier_hz, double duration_s) {
    const double omega = 2.0 * std::numbers::pi * carrier_hz;
    std::complex<double> sum = 0.0;
    for (const DrivePulse& pulse : pulses)
        sum += (std::polar(1.0, -omega * pulse.fall_s) - std::polar(1.0, -omega * pulse.rise_s)) /
               std::complex<double>(0.0, -omega);
    return sum * (2.0 / duration_s) / (2.0 / std::numbers::pi);
}

double left_of_difference(double bandwidth_hz, double time_s) {
    return std::exp(-std::numbers::pi * bandwidth_hz * time_s);
}

}  // namespace haptogram
