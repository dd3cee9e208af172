// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// Points on straight axes, metres: a line, a plane or a volume has one, two or three axes of more than one coordinate.
/// Points are numbered with x fastest and z slowest.
struct Grid {
    std::vector<double> x, y, z;

    [[nodiscard]] std::size_t size() const { return x.size() * y.size() * z.size(); }
    [[nodiscard]] Vec3 point(std::size_t i) const {
        return {x[i % x.size()], y[i / x.size() % y.size()], z[i / (x.size() * y.size())]};
    }
};

}  // namespace haptogram
