// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/shape_path.hpp"

#include <fmt/core.h>

#include <numeric>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/shape/tour.hpp"

namespace haptogram {
std::vector<std::size_t> reachable_points(const std::vector<Vec3>& points, const Array& array, bool clip) {
    std::string example;
    std::vector<std::size_t> reachable;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3 p = (1 / millimetre) * points[i];
        if (const std::string reason = array.unreachable(points[i]); reason.empty())
            reachable.push_back(i);
        else if (example.empty())
            example = fmt::format("({:.4g}, {:.4g}, {:.4g}) mm is {}", p.x, p.y, p.z, reason);
    }
    if (example.empty() || (clip && !reachable.empty())) return reachable;
    const Box box = bounding_box({.pieces = {Cloud{points}}});
    const Vec3 low = (1 / millimetre) * box.low, high = (1 / millimetre) * box.high;
    throw bad_input(array.file,
                    fmt::format("{} of {} points are out of reach: {}. They lie at x {:.4g}…{:.4g}, y {:.4g}…{:.4g}, "
                                "z {:.4g}…{:.4g} mm; built-in shapes stand at 0,0,130. Move or scale the shape{}",
                                points.size() - reachable.size(), points.size(), example, low.x, high.x, low.y, high.y,
                                low.z, high.z, reachable.empty() ? "" : ", or leave points out"),
                    reachable.empty() ? std::vector<std::string>{"center", "size"}
                                      : std::vector<std::string>{"center", "size", "clip"});
}

void require_room(std::size_t points, const ShapePathOptions& options) {
    if (points > options.most_points)
        throw bad_input(options.holder,
                        fmt::format("{} points, but the board holds {} ({}); take at most {}, or another board", points,
                                    options.most_points, options.capacity, options.most_points),
                        {"points", "board", "array"});
}

TouredPoints tour_of(const Shape& shape, const Array& array, const ShapePathOptions& options) {
    const Sampled sampled = sample(shape, options.points, options.seed);
    TouredPoints result;
    result.duplicates = sampled.duplicates_removed;
    std::vector<Vec3> points;
    for (const std::size_t i : reachable_points(sampled.points, array, options.clip))
        points.push_back(sampled.points[i]);
    result.clipped = sampled.points.size() - points.size();
    require_room(points.size(), options);
    std::vector<std::size_t> as_given(points.size());
    std::iota(as_given.begin(), as_given.end(), std::size_t{0});
    const std::vector<std::size_t> order = closed_tour(points);
    result.as_given_m = tour_length(points, as_given);
    result.tour_m = tour_length(points, order);
    for (const std::size_t i : order) result.points.push_back(points[i]);
    return result;
}

}  // namespace haptogram
