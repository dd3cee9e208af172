// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/cloud.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
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

}  // namespace haptogram
