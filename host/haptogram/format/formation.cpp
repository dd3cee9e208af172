// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/formation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptogram {

Formation formation(const Array& array, const Core& core, Vec3 focus, std::uint32_t foci) {
    double nearest = distance(focus, array.elements.front().position);
    double farthest = nearest;
    for (const Element& element : array.elements) {
        const double range = distance(focus, element.position);
        nearest = std::min(nearest, range);
        farthest = std::max(farthest, range);
    }
    Formation result;
    result.flight_spread_s = (farthest - nearest) / array.medium.speed_m_s;
    result.periods = static_cast<std::uint32_t>(std::ceil(array.carrier_hz * result.flight_spread_s));
    result.formation_s = result.periods / array.carrier_hz +
                         load_clocks(core.parameters, foci) / static_cast<double>(core.parameters.clock_hz);
    const double time_constant = 1.0 / (std::numbers::pi * array.transducer.bandwidth_hz);
    result.ring_up_s = std::log(10.0) * time_constant;
    return result;
}

Formation slowest_formation(const Array& array, const Core& core, std::span<const Vec3> points, std::uint32_t foci) {
    Formation slowest;
    for (const Vec3& point : points) {
        const Formation one = formation(array, core, point, foci);
        slowest.flight_spread_s = std::max(slowest.flight_spread_s, one.flight_spread_s);
        slowest.periods = std::max(slowest.periods, one.periods);
        slowest.formation_s = std::max(slowest.formation_s, one.formation_s);
        slowest.ring_up_s = std::max(slowest.ring_up_s, one.ring_up_s);
    }
    return slowest;
}

std::uint32_t most_points(double rate_hz, double formation_s) {
    return static_cast<std::uint32_t>(std::floor(1.0 / (rate_hz * formation_s)));
}

}  // namespace haptogram
