// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/drive_sequence.hpp"

#include <cmath>
#include <numbers>

namespace haptogram {

double left_of_difference(double bandwidth_hz, double time_s) {
    return std::exp(-std::numbers::pi * bandwidth_hz * time_s);
}

}  // namespace haptogram
