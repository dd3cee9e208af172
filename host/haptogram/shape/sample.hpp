// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

struct Sampled {
    std::vector<Vec3> points;            ///< metres, all different
    std::size_t duplicates_removed = 0;  ///< points that lay exactly on another; 0 when `points` are a choice of many
};

/// At most `count` points that cover the shape evenly. Curves alone are divided into equal arc lengths, a closed curve
/// into as many as it has points, an open one with a point on both ends. Clouds alone of no more than `count` points
/// are taken whole, in their order. Everything else is covered by farthest-point sampling of dense candidates.
/// The same arguments give the same points on every machine.
/// @throws Error{bad_argument} when `count` is 0 or there is nothing to sample
[[nodiscard]] Sampled sample(const Shape& shape, std::size_t count, std::uint64_t seed);

}  // namespace haptogram
