// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

struct Sampled {
    std::vector<Vec3> points;  ///< metres, all different
    std::size_t duplicates_removed =
        0;  ///< points that lay exactly on another; 0 when there were more candidates than asked for
};

/// At most `count` points that cover the shape evenly. A shape of curves only gets points at equal arc lengths; an open
/// curve has one at either end. A shape of clouds only, with no more than `count` points, is taken whole, in its order.
/// Everything else is covered densely with candidates, of which farthest-point sampling chooses.
/// The same arguments give the same points on every machine.
/// @throws Error{bad_argument} when `count` is 0 or there is nothing to sample
[[nodiscard]] Sampled sample(const Shape& shape, std::size_t count, std::uint64_t seed);

/// Shares `count` in the ratio of the weights: the whole parts, then one more for the largest remainders.
/// @param weights  not negative
[[nodiscard]] std::vector<std::size_t> share(std::size_t count, const std::vector<double>& weights);

}  // namespace haptogram
