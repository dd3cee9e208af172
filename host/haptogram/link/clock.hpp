// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>

namespace haptogram::link {

/// The time that a host lives in. It is given, never looked up, because a simulated board's time is not the wall's.
struct HostClock {
    std::function<double()> now_s;
    std::function<void(double until_s)> wait_until;  ///< returns at once when that has passed
};

/// The machine's own clock, from 0 at this call on.
[[nodiscard]] HostClock steady_clock();

}  // namespace haptogram::link
