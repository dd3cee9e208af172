// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/model/vec3.hpp"

namespace haptogram {

/// A short closed tour through all points, so that the focus jumps little (small jumps are less audible): from the
/// nearest-neighbour tour by 2-opt and Or-opt moves among each point's nearest neighbours (Bentley 1992), until none
/// shortens it. The same points give the same tour.
/// @return indices into `points`, beginning with 0; each once
[[nodiscard]] std::vector<std::size_t> closed_tour(const std::vector<Vec3>& points);

/// Length of the closed tour in the order given, metres.
[[nodiscard]] double tour_length(const std::vector<Vec3>& points, const std::vector<std::size_t>& order);

}  // namespace haptogram
