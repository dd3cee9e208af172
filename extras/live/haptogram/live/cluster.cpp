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

constexpr double depth_reach = 4.0;  ///< standard deviations of depth beyond which a neighbour counts nothing

void require(const char* name, bool good, double found, const char* expected) {
    if (!good) throw bad_argument(name, fmt::format("found {}, expected {}", found, expected));
}

/// Bits that hold the numbers from 0 to `most`.
unsigned bits_for(std::uint64_t most) {
    unsigned bits = 1;
    while ((most >> bits) != 0) ++bits;
    return bits;
}

struct Keyed {
    std::uint64_t key;
    std::uint32_t point;
};

/// Sorts by the lower `bits` of the keys, 11 at a time; equal keys keep their order.
void sort_by_key(std::vector<Keyed>& keyed, unsigned bits) {
    constexpr unsigned digit = 11;
    std::vector<Keyed> other(keyed.size());
    for (unsigned shift = 0; shift < bits; shift += digit) {
        std::array<std::uint32_t, (1U << digit) + 1> begin{};
        const auto digit_of = [shift](const Keyed& k) { return (k.key >> shift) & ((1U << digit) - 1); };
        for (const Keyed& k : keyed) ++begin[digit_of(k) + 1];
        for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
        for (const Keyed& k : keyed) other[begin[digit_of(k)]++] = k;
        keyed.swap(other);
    }
}

}  // namespace

CloudMaker::CloudMaker(const CloudOptions& options) : options_(options), reach_(options.window_px / 2) {
    require("window", options.window_px % 2 == 1 && options.window_px <= 31, options.window_px,
            "an odd number of pixels from 1 to 31");
    require("filter in the picture", options.space_px > 0.0, options.space_px, "more than 0 pixels");
    require("filter in depth", options.depth_m > 0.0, options.depth_m, "more than 0 m");
    require("cell", options.cell_m >= 0.0, options.cell_m, "0 m or more");
    const Vec3 size = options.high - options.low;
    require("workspace", size.x > 0.0 && size.y > 0.0 && size.z > 0.0, std::min({size.x, size.y, size.z}),
            "a box whose upper corner is above its lower one in x, y and z");
    const int reach = static_cast<int>(reach_);
    for (int v = -reach; v <= reach; ++v)
        for (int u = -reach; u <= reach; ++u)
            space_weights_.push_back(
                static_cast<float>(std::exp(-0.5 * (u * u + v * v) / (options.space_px * options.space_px))));
}

void CloudMaker::prepare_weights(double unit_m) {
    if (weights_unit_m_ == unit_m) return;
    weights_unit_m_ = unit_m;
    const auto most = static_cast<std::size_t>(std::min(65535.0, depth_reach * options_.depth_m / unit_m));
    depth_weights_.assign(most + 2, 0.0F);
    for (std::size_t counts = 0; counts <= most; ++counts) {
        const double far = static_cast<double>(counts) * unit_m / options_.depth_m;
        depth_weights_[counts] = static_cast<float>(std::exp(-0.5 * far * far));
    }
}

void CloudMaker::cut_out(const DepthCamera& camera, const DepthPicture& picture) {
    stride_ = camera.width + std::size_t{2} * reach_;
    kept_.assign(stride_ * (camera.height + std::size_t{2} * reach_), 0);
    pixels_.clear();
    // Only counts between those of the workspace's nearest and farthest corners need to be looked at closely.
    double nearest = 1e9, farthest = -1e9;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const Vec3 p{(corner & 1U) != 0 ? options_.high.x : options_.low.x,
                     (corner & 2U) != 0 ? options_.high.y : options_.low.y,
                     (corner & 4U) != 0 ? options_.high.z : options_.low.z};
        const double depth = dot(p - camera.pose.origin, camera.pose.z) / camera.unit_m;
        nearest = std::min(nearest, depth);
        farthest = std::max(farthest, depth);
    }
    const auto low = static_cast<std::uint32_t>(std::clamp(std::floor(nearest), 1.0, 65535.0));
    const auto high = static_cast<std::uint32_t>(std::clamp(std::ceil(farthest), 0.0, 65535.0));
    for (std::uint32_t v = 0; v < camera.height; ++v) {
        const std::uint16_t* row = picture.data() + std::size_t{v} * camera.width;
        const std::size_t begin = (v + reach_) * stride_ + reach_;
        const Vec3 ray = camera.pose.turned(
            {-camera.centre_x_px / camera.focal_x_px, (v - camera.centre_y_px) / camera.focal_y_px, 1.0});
        for (std::uint32_t u = 0; u < camera.width; ++u) {
            if (row[u] < low || row[u] > high) continue;
            const Vec3 p =
                camera.pose.origin + (row[u] * camera.unit_m) * (ray + (u / camera.focal_x_px) * camera.pose.x);
            if (p.x < options_.low.x || p.y < options_.low.y || p.z < options_.low.z || p.x > options_.high.x ||
                p.y > options_.high.y || p.z > options_.high.z)
                continue;
            kept_[begin + u] = row[u];
            pixels_.push_back(begin + u);
        }
    }
}

float CloudMaker::filtered(std::size_t at) const {
    const int centre = kept_[at];
    const int none = static_cast<int>(depth_weights_.size()) - 1;
    float weight = 0.0F, shift = 0.0F;
    const float* space = space_weights_.data();
    for (std::size_t row = at - reach_ * stride_ - reach_; row <= at + reach_ * stride_; row += stride_)
        for (std::size_t neighbour = row; neighbour <= row + std::size_t{2} * reach_; ++neighbour, ++space) {
            const int away = kept_[neighbour] - centre;
            const float share = kept_[neighbour] == 0
                                    ? 0.0F
                                    : *space * depth_weights_[static_cast<std::size_t>(std::min(std::abs(away), none))];
            weight += share;
            shift += share * static_cast<float>(away);
        }
    return static_cast<float>(centre) + shift / weight;
}

std::vector<Vec3> CloudMaker::points(const DepthCamera& camera, const DepthPicture& picture) {
    require_sound(camera);
    if (picture.size() != std::size_t{camera.width} * camera.height)
        throw bad_argument("picture",
                           fmt::format("{} counts; expected {} x {}", picture.size(), camera.width, camera.height));
    cut_out(camera, picture);
    prepare_weights(camera.unit_m);
    std::vector<Vec3> points;
    points.reserve(pixels_.size());
    for (const std::size_t at : pixels_) {
        const double z = (reach_ == 0 ? kept_[at] : filtered(at)) * camera.unit_m;
        const auto u = static_cast<double>(at % stride_ - reach_), v = static_cast<double>(at / stride_ - reach_);
        points.push_back(camera.pose.outwards(
            {(u - camera.centre_x_px) * z / camera.focal_x_px, (v - camera.centre_y_px) * z / camera.focal_y_px, z}));
    }
    return points;
}

std::vector<Vec3> CloudMaker::cloud(std::span<const DepthCamera> cameras, const DepthShot& shot) {
    if (shot.pictures.size() != cameras.size())
        throw bad_argument("shot", fmt::format("{} pictures of {} cameras", shot.pictures.size(), cameras.size()));
    std::vector<Vec3> all;
    for (std::size_t i = 0; i < cameras.size(); ++i) {
        if (!shot.pictures[i]) continue;
        const std::vector<Vec3> seen = points(cameras[i], *shot.pictures[i]);
        all.insert(all.end(), seen.begin(), seen.end());
    }
    return options_.cell_m > 0.0 ? voxel_grid(all, options_.cell_m) : all;
}

std::vector<Vec3> voxel_grid(std::span<const Vec3> points, double cell_m) {
    require("cell", cell_m > 0.0, cell_m, "more than 0 m");
    if (points.empty()) return {};
    Vec3 low = points.front(), high = points.front();
    for (const Vec3& p : points) {
        if (!is_finite(p)) throw bad_argument("points", "one is not finite");
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    const auto cell = [cell_m](double x) { return std::floor(x / cell_m); };
    std::array<unsigned, 3> bits{};
    const std::array<double, 3> first{cell(low.x), cell(low.y), cell(low.z)},
        last{cell(high.x), cell(high.y), cell(high.z)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        require("points", last.at(axis) - first.at(axis) < 0x1p20, last.at(axis) - first.at(axis),
                "less than 2^20 cells between them");
        bits.at(axis) = bits_for(static_cast<std::uint64_t>(last.at(axis) - first.at(axis)));
    }
    std::vector<Keyed> keyed(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto x = static_cast<std::uint64_t>(cell(points[i].x) - first[0]);
        const auto y = static_cast<std::uint64_t>(cell(points[i].y) - first[1]);
        const auto z = static_cast<std::uint64_t>(cell(points[i].z) - first[2]);
        keyed[i] = {(((x << bits[1]) | y) << bits[2]) | z, static_cast<std::uint32_t>(i)};
    }
    sort_by_key(keyed, bits[0] + bits[1] + bits[2]);
    std::vector<Vec3> means;
    for (std::size_t i = 0; i < keyed.size();) {
        Vec3 sum;
        std::size_t end = i;
        for (; end < keyed.size() && keyed[end].key == keyed[i].key; ++end) sum = sum + points[keyed[end].point];
        means.push_back(sum * (1.0 / static_cast<double>(end - i)));
        i = end;
    }
    return means;
}

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
