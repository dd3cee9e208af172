// SPDX-License-Identifier: Apache-2.0
#include "hands.hpp"

#include <cmath>

#include "haptogram/hand/open.hpp"
#include "haptogram/hand/project.hpp"
#include "haptogram/hand/render.hpp"

namespace haptogram::cli {

void use_hands_of_this_build() { use_hands(); }

std::function<HandSkin(Vec3)> skin_of_hand(const std::string& recording, const std::string& model, std::size_t frame) {
    return [skin = skin_of(open_hands(recording, model), frame)](Vec3 place) {
        HandSkin nearest;
        double least = INFINITY;
        for (const SkinRegion& region : skin) {
            const SkinPoint point = region.nearest(place);
            if (const double away = distance(point.position, place); away < least) {
                least = away;
                nearest = {point.position, point.normal, std::string(region.name)};
            }
        }
        return nearest;
    };
}

}  // namespace haptogram::cli
