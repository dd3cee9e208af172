// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/scenes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/robot/place.hpp"

namespace haptogram::fusion {
namespace {

/// A weight of nothing is a hand without a load.
void require_weight(double weight_n) {
    if (!(weight_n >= 0.0 && std::isfinite(weight_n)))
        throw bad_argument("weight", fmt::format("must not be negative, found {:g} N", weight_n));
}

/// So many of the points, beginning with number `first`, which then is the next one's turn.
std::vector<Vec3> turn(const std::vector<Vec3>& points, std::size_t most, std::size_t& first) {
    if (points.size() <= most) return points;
    std::vector<Vec3> taken;
    for (std::size_t i = 0; i < most; ++i) taken.push_back(points[(first + i) % points.size()]);
    first = (first + most) % points.size();
    return taken;
}

}  // namespace

Scene scene_of(const ExploreScene& explored, const SharedClock& clock, double body_kg) {
    require_weight(explored.weight_n);
    if (!(explored.frequency_hz > 0.0 && std::isfinite(explored.frequency_hz)))
        throw bad_argument("frequency", fmt::format("must be positive, found {:g} Hz", explored.frequency_hz));
    const double stiffest = 4.0 * body_kg / (clock.period_s() * clock.period_s());
    if (!(explored.surface.stiffness_n_m < stiffest))
        throw bad_argument("stiffness",
                           fmt::format("found {:g} N/m; a body of {:g} kg that moves every {:g} ms swings "
                                       "on a surface of {:.0f} N/m or more",
                                       explored.surface.stiffness_n_m, body_kg, clock.period_s() * 1e3, stiffest));
    const std::size_t places = places_of(clock, explored.frequency_hz);
    return [explored, places, first = std::make_shared<std::size_t>(0)](const Moment& moment) {
        const Hand hand = open_hand(moment.palm, explored.tilt_deg);
        const robot::Vector3 position(moment.body.x, moment.body.y, moment.body.z);
        Stimulus stimulus = explore(explored.object, hand, palmar_surface(hand), explored.weight_n, explored.surface,
                                    position, moment.velocity, explored.slice);
        stimulus.points = turn(stimulus.points, places, *first);
        stimulus.magnitude = explored.magnitude;
        stimulus.frequency_hz = explored.frequency_hz;
        return stimulus;
    };
}

PalmValue palm_value(const std::string& name) {
    for (const auto& [known, value] :
         {std::pair("distance", PalmValue::distance), std::pair("texture", PalmValue::texture),
          std::pair("hardness", PalmValue::hardness)})
        if (name == known) return value;
    throw bad_argument("value", fmt::format("found \"{}\", expected distance, texture or hardness", name));
}

Scene scene_of(const TellScene& told) {
    require_weight(told.weight_n);
    const auto value_at = [told](Vec3 palm) {
        switch (told.value) {
            case PalmValue::distance: return nearness(palm.z - told.height_m, told.range_m);
            case PalmValue::texture: return cloth(palm.x, palm.y, told.cell_m);
            case PalmValue::hardness: return hardness(told.stiffness_n_m, told.softest_n_m, told.hardest_n_m);
        }
        throw bad_argument("value", "is none that a pattern tells");
    };
    // What makes no sense is said before the run.
    static_cast<void>(tell(told.pattern, value_at({0.0, 0.0, told.height_m}), open_hand({0.0, 0.0, told.height_m}, 0.0),
                           told.points));
    return [told, value_at](const Moment& moment) {
        Stimulus stimulus;
        const bool reached = told.value == PalmValue::distance || moment.palm.z <= told.height_m;
        if (reached)
            stimulus = tell(told.pattern, value_at(moment.palm), open_hand(moment.palm, 0.0),
                            told.pattern.shape == PalmShape::focus ? 1 : told.points);
        stimulus.wrench[2] = -told.weight_n;
        return stimulus;
    };
}

}  // namespace haptogram::fusion
