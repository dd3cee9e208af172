// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/stimulus.hpp"

#include <fmt/format.h>

#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::fusion {

SharedClock shared_clock(double period_s, double carrier_hz) {
    constexpr double most_off = 1e-6;  // of a period: far below a tick of the board
    const double periods = period_s * carrier_hz, whole = std::round(periods);
    if (!(carrier_hz > 0.0) || !(whole >= 1.0 && whole <= 1e6) || std::abs(periods - whole) > most_off * whole)
        throw bad_argument("period", fmt::format("a period of the robot must be a whole number of carrier periods, up "
                                                 "to a million; found {:g} s, which are {:.6g} periods of {:g} Hz",
                                                 period_s, periods, carrier_hz));
    return {carrier_hz, static_cast<std::uint32_t>(whole)};
}

}  // namespace haptogram::fusion
