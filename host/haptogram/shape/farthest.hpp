// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// Farthest-point sampling (Gonzalez 1985). It begins with `first` and then chooses, again and again, the candidate
/// that is farthest from all chosen ones; among equals the one with the lowest index. The least distance between two
/// chosen points is at least half of the best possible. It ends early when every candidate coincides with a chosen one.
/// @return indices in the order of choice
[[nodiscard]] std::vector<std::size_t> farthest_points(const std::vector<Vec3>& candidates, std::size_t count,
                                                       std::size_t first);

}  // namespace haptogram
