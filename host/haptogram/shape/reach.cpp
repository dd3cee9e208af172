// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/reach.hpp"

#include "haptogram/shape/shape_path.hpp"

namespace haptogram {

void require_reachable(const Path& path, const Array& array) {
    std::vector<Vec3> points;
    for (const PathStep& step : path.steps)
        for (const Focus& focus : step.foci) points.push_back(focus.position);
    (void)reachable_points(points, array, false);  // throws when one is not
}

}  // namespace haptogram
