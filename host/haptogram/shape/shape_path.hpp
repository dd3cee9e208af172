// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// How a shape becomes points for one focus that visits them in turn.
struct ShapePathOptions {
    std::size_t points = 200;          ///< to take from a surface, a curve or a larger cloud
    std::uint64_t seed = 1;            ///< of the sampling
    bool clip = false;                 ///< leave out points that the array cannot reach, instead of refusing the shape
    std::size_t most_points = 65'535;  ///< the most that can be played
    std::string holder, capacity;  ///< what plays them, and its limit in words, for messages: "tile-100", "400 records"
};

/// Points in the order in which the focus visits them, and what became of the shape.
struct TouredPoints {
    std::vector<Vec3> points;               ///< metres, array frame, along a short closed tour
    std::size_t clipped = 0;                ///< out of reach and left out
    std::size_t duplicates = 0;             ///< that lay exactly on another and were left out
    double tour_m = 0.0, as_given_m = 0.0;  ///< lengths of the tour, and of the order before it
};

/// Which of the points the array can reach.
/// @param clip  leave out the others; otherwise they are an error
/// @return their numbers, in order
/// @throws Error{bad_input} that lists points out of reach, or says that none is left
[[nodiscard]] std::vector<std::size_t> reachable_points(const std::vector<Vec3>& points, const Array& array, bool clip);

/// @throws Error{bad_input} when there are more points than `options.most_points`
void require_room(std::size_t points, const ShapePathOptions& options);

/// Samples a shape, keeps what the array can reach, and orders it into a short closed tour.
/// @throws Error{bad_input} naming the points out of reach, or when there are more points than can be held
[[nodiscard]] TouredPoints tour_of(const Shape& shape, const Array& array, const ShapePathOptions& options);

}  // namespace haptogram
