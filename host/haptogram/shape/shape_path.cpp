// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/shape_path.hpp"

#include <fmt/core.h>

#include <numeric>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/tour.hpp"

namespace haptogram {
std::vector<std::size_t> reachable_points(const std::vector<Vec3>& points, const Array& array, bool clip) {
    constexpr std::size_t most_listed = 10;
    std::string listed;
    std::size_t count = 0;
    std::vector<std::size_t> reachable;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3& p = points[i];
        const std::string reason = array.unreachable(p);
        if (reason.empty()) {
            reachable.push_back(i);
            continue;
        }
        if (++count <= most_listed)
            listed += fmt::format("\n  ({:.6g}, {:.6g}, {:.6g}) mm: {}", p.x / millimetre, p.y / millimetre,
                                  p.z / millimetre, reason);
    }
    if (count == 0) return reachable;
    if (count > most_listed) listed += fmt::format("\n  and {} more", count - most_listed);
    if (!clip)
        throw bad_input(array.file,
                        fmt::format("{} of {} points are out of reach:{}\nmove or scale the shape, or leave them out",
                                    count, points.size(), listed),
                        {"center", "size", "clip"});
    if (reachable.empty())
        throw bad_input(array.file, fmt::format("no point is left: all {} are out of reach:{}", points.size(), listed),
                        {"center", "size"});
    return reachable;
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
