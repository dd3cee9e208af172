// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// Signed distances of a solid on a lattice around it. A distance changes by no more than the way between two places,
/// so the nearest place of the lattice bounds it everywhere, in a fraction of the time.
class DistanceGrid {
public:
    /// @param low, high  corners of a box around the solid, metres
    /// @param distance   the signed distance, negative inside
    DistanceGrid(Vec3 low, Vec3 high, const std::function<double(Vec3)>& distance);

    /// Of a finite place: a number with the sign of the distance at `p`, and no farther from 0; 0 where the lattice
    /// does not tell.
    [[nodiscard]] double bound(Vec3 p) const;

private:
    [[nodiscard]] Vec3 place(std::size_t i, std::size_t j, std::size_t k) const;

    Vec3 low_, high_;
    double step_;
    std::array<std::size_t, 3> count_;
    std::vector<float> distances_;  ///< x runs fastest
};

}  // namespace haptogram
