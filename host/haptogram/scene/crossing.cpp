// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scene/crossing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptogram {
namespace {

constexpr double cos_45 = 0.5 * std::numbers::sqrt2;
constexpr std::size_t most_votes = 64;  ///< more points than that tell nothing new

}  // namespace

std::optional<Vec3> inward_at(const Solid& solid, Vec3 place) {
    constexpr double step = 1e-6, least_slope = 0.9;
    const auto slope = [&](Vec3 way) {
        return (solid.distance(place + step * way) - solid.distance(place - step * way)) / (2.0 * step);
    };
    const Vec3 out{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
    // The slope is 1 but where two parts of the surface are equally near.
    if (!(norm(out) > least_slope)) return {};
    return out * (-1.0 / norm(out));
}

double depth_along(const Solid& solid, Vec3 place, Vec3 inward) {
    constexpr double there = 1e-7;
    double depth = 0.0;
    for (int step = 0; step < 200; ++step) {
        const double left = -solid.distance(place - depth * inward);
        if (left < there) break;
        depth += left;
    }
    return depth;
}

Crossing::Crossing(const Solid& solid, std::span<const Vec3> outside) {
    constexpr double below = 1e-4;  ///< a face's normal is looked up so far behind it
    const std::size_t stride = std::max<std::size_t>(1, (outside.size() + most_votes - 1) / most_votes);
    for (std::size_t i = 0; i < outside.size(); i += stride) {
        const std::optional<Vec3> way = inward_at(solid, outside[i]);
        if (!way) continue;
        const Vec3 behind = outside[i] + (solid.distance(outside[i]) + below) * *way;
        if (const std::optional<Vec3> vote = inward_at(solid, behind)) votes_.push_back(*vote);
    }
}

std::size_t Crossing::votes_for(Vec3 inward) const {
    return static_cast<std::size_t>(
        std::count_if(votes_.begin(), votes_.end(), [&](Vec3 vote) { return dot(vote, inward) > cos_45; }));
}

std::optional<Vec3> Crossing::inward() const {
    if (votes_.empty()) return {};
    std::size_t most = 0;
    Vec3 best;
    for (const Vec3& vote : votes_)
        if (const std::size_t votes = votes_for(vote); votes > most) {
            most = votes;
            best = vote;
        }
    Vec3 sum;
    for (const Vec3& vote : votes_)
        if (dot(vote, best) > cos_45) sum = sum + vote;
    return sum * (1.0 / norm(sum));
}

}  // namespace haptogram
