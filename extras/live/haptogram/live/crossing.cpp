// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/crossing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace haptogram {
namespace {

constexpr double cos_45 = 0.5 * std::numbers::sqrt2;
constexpr std::size_t most_votes = 64;  ///< more points than that tell nothing new

/// Of the convex hull of points in a plane, m²: Andrew's chain, its lower half and then its upper one.
double hull_area(std::vector<std::array<double, 2>> points) {
    std::sort(points.begin(), points.end());
    double twice = 0.0;
    for (int half = 0; half < 2; ++half) {
        std::vector<std::array<double, 2>> chain;
        for (const auto& p : points) {
            const auto turns_left = [&](const auto& a, const auto& b) {
                return (b[0] - a[0]) * (p[1] - b[1]) > (b[1] - a[1]) * (p[0] - b[0]);
            };
            while (chain.size() > 1 && !turns_left(chain[chain.size() - 2], chain.back())) chain.pop_back();
            chain.push_back(p);
        }
        for (std::size_t i = 1; i < chain.size(); ++i)
            twice += chain[i - 1][0] * chain[i][1] - chain[i][0] * chain[i - 1][1];
        std::reverse(points.begin(), points.end());
    }
    return 0.5 * twice;
}

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
        if (const std::optional<Vec3> inward = inward_at(solid, behind)) votes_.push_back({outside[i], *inward});
    }
}

Crossing::Crossing(const Crossing& a, const Crossing& b) : votes_(a.votes_) {
    votes_.insert(votes_.end(), b.votes_.begin(), b.votes_.end());
}

double Crossing::area(Vec3 inward) const {
    const Vec3 level = std::abs(inward.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    const Vec3 x = cross(inward, level) * (1.0 / norm(cross(inward, level))), y = cross(inward, x);
    std::vector<std::array<double, 2>> points;
    for (const Vote& vote : votes_)
        if (dot(vote.inward, inward) > cos_45) points.push_back({dot(vote.place, x), dot(vote.place, y)});
    return hull_area(std::move(points));
}

std::optional<Vec3> Crossing::inward() const {
    constexpr double same_face = 0.985;  // within 10°: its section is about the same
    if (votes_.empty()) return {};
    std::vector<Vec3> faces;
    double most = -1.0;
    Vec3 best;
    for (const Vote& vote : votes_) {
        if (std::any_of(faces.begin(), faces.end(), [&](Vec3 face) { return dot(face, vote.inward) > same_face; }))
            continue;
        faces.push_back(vote.inward);
        if (const double through = area(vote.inward); through > most) {
            most = through;
            best = vote.inward;
        }
    }
    Vec3 sum;
    for (const Vote& vote : votes_)
        if (dot(vote.inward, best) > cos_45) sum = sum + vote.inward;
    return sum * (1.0 / norm(sum));
}

}  // namespace haptogram
