// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/cluster.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

/// Sets of cells that grow together.
class Sets {
public:
    explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
    std::size_t find(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::size_t a, std::size_t b) { parent_[std::max(find(a), find(b))] = std::min(find(a), find(b)); }

private:
    std::vector<std::size_t> parent_;
};

struct CellHash {
    std::size_t operator()(const std::array<std::int64_t, 3>& cell) const {
        std::uint64_t hash = 0;
        for (const std::int64_t part : cell) hash = (hash ^ static_cast<std::uint64_t>(part)) * 0x9E3779B97F4A7C15U;
        return hash ^ (hash >> 32U);
    }
};
using Cell = std::array<std::int64_t, 3>;

/// Points in cells so small that all points of one are joined. `cells` is in the order of first points.
struct Cells {
    std::unordered_map<Cell, std::size_t, CellHash> number;
    std::vector<Cell> place;
    std::vector<std::vector<std::size_t>> points;

    Cells(std::span<const Vec3> all, double distance_m) {
        const double edge = distance_m / std::sqrt(3.0) * (1.0 - 1e-9);
        for (std::size_t i = 0; i < all.size(); ++i) {
            const Cell cell{std::llround(std::floor(all[i].x / edge)), std::llround(std::floor(all[i].y / edge)),
                            std::llround(std::floor(all[i].z / edge))};
            const auto [found, fresh] = number.try_emplace(cell, place.size());
            if (fresh) {
                place.push_back(cell);
                points.emplace_back();
            }
            points[found->second].push_back(i);
        }
    }
};

bool near(std::span<const Vec3> all, const std::vector<std::size_t>& a, const std::vector<std::size_t>& b,
          double distance_m) {
    for (const std::size_t i : a)
        for (const std::size_t j : b)
            if (const Vec3 way = all[i] - all[j]; dot(way, way) <= distance_m * distance_m) return true;
    return false;
}

/// Joins cells whose points are near enough. Cells are farther apart than the distance beyond two cells between them.
Sets joined_cells(std::span<const Vec3> all, const Cells& cells, double distance_m) {
    Sets sets(cells.place.size());
    for (std::size_t one = 0; one < cells.place.size(); ++one)
        for (std::int64_t x = -2; x <= 2; ++x)
            for (std::int64_t y = -2; y <= 2; ++y)
                for (std::int64_t z = -2; z <= 2; ++z) {
                    const auto found =
                        cells.number.find({cells.place[one][0] + x, cells.place[one][1] + y, cells.place[one][2] + z});
                    if (found == cells.number.end() || found->second <= one) continue;
                    if (sets.find(one) != sets.find(found->second) &&
                        near(all, cells.points[one], cells.points[found->second], distance_m))
                        sets.join(one, found->second);
                }
    return sets;
}

}  // namespace

std::vector<Cluster> clusters_of(std::span<const Vec3> points, double distance_m, std::size_t least) {
    if (!(distance_m > 0.0))
        throw bad_argument("cluster distance", fmt::format("found {} m, expected more than 0", distance_m));
    for (const Vec3& p : points)
        if (!is_finite(p)) throw bad_argument("points", "one is not finite");
    const Cells cells(points, distance_m);
    Sets sets = joined_cells(points, cells, distance_m);
    std::vector<std::vector<std::size_t>> members(cells.place.size());
    for (std::size_t i = 0; i < cells.place.size(); ++i) {
        auto& of_set = members[sets.find(i)];
        of_set.insert(of_set.end(), cells.points[i].begin(), cells.points[i].end());
    }
    std::erase_if(members, [least](const auto& of_set) { return of_set.empty() || of_set.size() < least; });
    for (auto& of_set : members) std::sort(of_set.begin(), of_set.end());
    std::sort(members.begin(), members.end(), [](const auto& a, const auto& b) {
        return std::tuple(b.size(), a.front()) < std::tuple(a.size(), b.front());
    });
    std::vector<Cluster> clusters;
    for (const auto& of_set : members) {
        Cluster& cluster = clusters.emplace_back();
        for (const std::size_t i : of_set) {
            cluster.points.push_back(points[i]);
            cluster.centroid = cluster.centroid + points[i];
        }
        cluster.centroid = cluster.centroid * (1.0 / static_cast<double>(of_set.size()));
    }
    return clusters;
}

double width_across(std::span<const Vec3> points, Vec3 normal) {
    constexpr int directions = 12;
    const Vec3 level = std::abs(normal.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 x = cross(normal, level) * (1.0 / norm(cross(normal, level))), y = cross(normal, x);
    double widest = 0.0;
    for (int i = 0; i < directions; ++i) {
        const double turn = i * std::numbers::pi / directions;
        const Vec3 way = std::cos(turn) * x + std::sin(turn) * y;
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (const Vec3& p : points) {
            low = std::min(low, dot(p, way));
            high = std::max(high, dot(p, way));
        }
        widest = std::max(widest, high - low);
    }
    return widest;
}

Cluster together(const Cluster& a, const Cluster& b) {
    Cluster all = a;
    all.points.insert(all.points.end(), b.points.begin(), b.points.end());
    const double share = static_cast<double>(b.points.size()) / static_cast<double>(all.points.size());
    all.centroid = a.centroid + share * (b.centroid - a.centroid);
    return all;
}

FingerTracker::FingerTracker(double gate_m) : gate_m_(gate_m) {
    if (!(gate_m > 0.0)) throw bad_argument("gate", fmt::format("found {} m, expected more than 0", gate_m));
}

const std::vector<TrackedFinger>& FingerTracker::update(const std::vector<Cluster>& clusters) {
    std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;  // distance, finger, cluster
    for (std::size_t f = 0; f < fingers_.size(); ++f)
        for (std::size_t c = 0; c < clusters.size(); ++c)
            if (const double way = distance(fingers_[f].place, clusters[c].centroid); way <= gate_m_)
                pairs.emplace_back(way, f, c);
    std::sort(pairs.begin(), pairs.end());
    std::vector<bool> found(fingers_.size(), false), taken(clusters.size(), false);
    for (const auto& [way, f, c] : pairs) {
        if (found[f] || taken[c]) continue;
        found[f] = taken[c] = true;
        fingers_[f] = {fingers_[f].id, clusters[c].centroid, c, true};
    }
    std::vector<TrackedFinger> now;
    for (std::size_t f = 0; f < found.size(); ++f) {
        if (!found[f] && !fingers_[f].seen) continue;
        now.push_back(fingers_[f]);
        now.back().seen = found[f];
    }
    for (std::size_t c = 0; c < clusters.size(); ++c)
        if (!taken[c]) now.push_back({next_++, clusters[c].centroid, c, true});
    fingers_ = std::move(now);
    return fingers_;
}

}  // namespace haptogram
