// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// A short closed tour through all points. Short, because small jumps of the focus are less audible. The tour to the
/// nearest unvisited neighbour is shortened by 2-opt and Or-opt moves among each point's nearest neighbours (Bentley
/// 1992), until no move shortens it. The same points give the same tour.
/// @return indices into `points`, each once, beginning with 0
[[nodiscard]] std::vector<std::size_t> closed_tour(const std::vector<Vec3>& points);

/// Length of the closed tour in the order given, metres.
[[nodiscard]] double tour_length(const std::vector<Vec3>& points, const std::vector<std::size_t>& order);

}  // namespace haptogram
