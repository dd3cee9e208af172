// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/clock.hpp"

#include <chrono>
#include <thread>

namespace haptogram::link {

HostClock steady_clock() {
    using Steady = std::chrono::steady_clock;
    const Steady::time_point start = Steady::now();
    return {[start] { return std::chrono::duration<double>(Steady::now() - start).count(); },
            [start](double until_s) {
                std::this_thread::sleep_until(
                    start + std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(until_s)));
            }};
}

}  // namespace haptogram::link
