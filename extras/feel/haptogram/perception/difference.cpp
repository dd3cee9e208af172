// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/difference.hpp"

#include <algorithm>
#include <cmath>

namespace haptogram::perception {

std::array<unsigned, 2> strength_steps(double over_db) {
    constexpr double most_db = 2.98, least_db = 1.65;
    const auto steps = [over_db](double step_db) {
        return static_cast<unsigned>(std::floor(std::max(0.0, over_db) / step_db));
    };
    return {steps(most_db), steps(least_db)};
}

std::optional<std::array<double, 2>> next_frequency_hz(double hz) {
    constexpr double lowest_hz = 2.0, highest_hz = 300.0, least = 0.13, most = 0.38;
    if (!(hz >= lowest_hz && hz <= highest_hz)) return std::nullopt;
    return std::array<double, 2>{hz * (1.0 + least), hz * (1.0 + most)};
}

}  // namespace haptogram::perception
