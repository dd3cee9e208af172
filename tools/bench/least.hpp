// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <chrono>

namespace haptogram::bench {

/// The least time of several runs, s: other programs only add to it.
template <class Call>
double least_s(int repeats, Call call) {
    double least = 1e9;
    for (int i = 0; i < repeats; ++i) {
        const auto begun = std::chrono::steady_clock::now();
        call();
        least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
    }
    return least;
}

}  // namespace haptogram::bench
