// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/model/vec3.hpp"

namespace haptogram {

/// Farthest-point sampling: beginning with `first`, chooses again and again the candidate farthest from all chosen
/// ones, the lowest index among equals (Gonzalez 1985; the least distance between two chosen points is at least half of
/// the best possible). Ends early when every place is taken, so it returns fewer than `count` when candidates coincide.
/// @return indices in the order of choice
[[nodiscard]] std::vector<std::size_t> farthest_points(const std::vector<Vec3>& candidates, std::size_t count,
                                                       std::size_t first);

}  // namespace haptogram
