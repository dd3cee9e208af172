// SPDX-License-Identifier: Apache-2.0
#include "haptogram/render/shape_path.hpp"

#include <fmt/core.h>

#include <numeric>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/sample.hpp"
#include "haptogram/shape/tour.hpp"

namespace haptogram {
namespace {

/// Leaves out what cannot be reached, or refuses the whole shape and says which points.
/// @return how many were left out
std::size_t keep_reachable(std::vector<Vec3>& points, const Array& array, bool clip) {
    constexpr std::size_t most_listed = 10;
    std::string listed;
    std::size_t count = 0;
    std::vector<Vec3> reachable;
    for (const Vec3& p : points) {
        const std::string reason = array.unreachable(p);
        if (reason.empty()) {
            reachable.push_back(p);
            continue;
        }
        if (++count <= most_listed)
            listed += fmt::format("\n  ({:.2f}, {:.2f}, {:.2f}) mm: {}", p.x / millimetre, p.y / millimetre,
                                  p.z / millimetre, reason);
    }
    if (count == 0) return 0;
    if (count > most_listed) listed += fmt::format("\n  and {} more", count - most_listed);
    if (!clip)
        throw bad_input(array.file,
                        fmt::format("{} of {} points are out of reach:{}\nmove or scale the shape, or leave them out",
                                    count, points.size(), listed),
                        {"center", "size", "clip"});
    if (reachable.empty())
        throw bad_input(array.file, fmt::format("no point is left: all {} are out of reach:{}", points.size(), listed),
                        {"center", "size"});
    points = std::move(reachable);
    return count;
}

}  // namespace

TouredPoints tour_of(const Shape& shape, const Array& array, const ShapePathOptions& options) {
    Sampled sampled = sample(shape, options.points, options.seed);
    TouredPoints result;
    result.duplicates = sampled.duplicates_removed;
    result.clipped = keep_reachable(sampled.points, array, options.clip);
    if (sampled.points.size() > options.most_points)
        throw bad_input(options.holder,
                        fmt::format("{} points, but the board holds {} ({}); take at most {}, or another board",
                                    sampled.points.size(), options.most_points, options.capacity, options.most_points),
                        {"points", "board", "array"});
    std::vector<std::size_t> as_given(sampled.points.size());
    std::iota(as_given.begin(), as_given.end(), std::size_t{0});
    const std::vector<std::size_t> order = closed_tour(sampled.points);
    result.as_given_m = tour_length(sampled.points, as_given);
    result.tour_m = tour_length(sampled.points, order);
    for (const std::size_t i : order) result.points.push_back(sampled.points[i]);
    return result;
}

}  // namespace haptogram
