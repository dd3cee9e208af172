// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/schedule.hpp"

#include <fmt/core.h>

#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram {

std::vector<std::uint32_t> even_dwells(double carrier_hz, double rate_hz, std::size_t count,
                                       std::uint32_t most_periods) {
    const double total = carrier_hz / rate_hz;
    const double each = total / static_cast<double>(count);
    const double fastest_hz = carrier_hz / static_cast<double>(count);
    if (each < 1.0)
        throw impossible(
            "rate",
            fmt::format(
                "{} points at {} Hz leave {:.2f} carrier cycles a point, and a focus lasts at least "
                "one; at most {:.6g} Hz can be reached with these points{}",
                count, rate_hz, each, fastest_hz,
                total >= 1.0 ? fmt::format(", or {} points at this rate", static_cast<std::size_t>(total)) : ""));
    if (each > most_periods)
        throw impossible("rate", fmt::format("{} points at {} Hz leave {:.4g} carrier cycles a point, and a sequence "
                                             "entry holds {}; at least {:.6g} Hz",
                                             count, rate_hz, each, most_periods, fastest_hz / most_periods));
    std::vector<std::uint32_t> dwells;
    std::uint64_t given = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto until = static_cast<std::uint64_t>(std::llround(each * static_cast<double>(i + 1)));
        dwells.push_back(static_cast<std::uint32_t>(until - given));
        given = until;
    }
    return dwells;
}

Path path_through(const std::vector<Vec3>& points, const std::vector<std::uint32_t>& dwells) {
    Path path;
    for (std::size_t i = 0; i < points.size(); ++i) path.steps.push_back({{{points[i]}}, dwells.at(i)});
    return path;
}

}  // namespace haptogram
