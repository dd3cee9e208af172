// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// Farthest-point sampling (Gonzalez 1985). It begins with `first` and then chooses, again and again, the candidate
/// that is farthest from all chosen ones; among equals the one with the lowest index. The least distance between two
/// chosen points is at least half of the best possible. It ends early when every candidate coincides with a chosen one.
/// @return indices in the order of choice
[[nodiscard]] std::vector<std::size_t> farthest_points(const std::vector<Vec3>& candidates, std::size_t count,
                                                       std::size_t first);

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

/// A short closed tour through all points. Short, because small jumps of the focus are less audible. The tour to the
/// nearest unvisited neighbour is shortened by 2-opt and Or-opt moves among each point's nearest neighbours (Bentley
/// 1992), until no move shortens it. The same points give the same tour.
/// @return indices into `points`, each once, beginning with 0
[[nodiscard]] std::vector<std::size_t> closed_tour(const std::vector<Vec3>& points);

/// Length of the closed tour in the order given, metres.
[[nodiscard]] double tour_length(const std::vector<Vec3>& points, const std::vector<std::size_t>& order);

}  // namespace haptogram
