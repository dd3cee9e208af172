// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/distance_grid.hpp"

#include <algorithm>
#include <cmath>

namespace haptogram {
namespace {

/// Along the longest edge of the box. More take longer to make, and tell more of the skin near the surface.
constexpr double steps = 32.0;

}  // namespace

DistanceGrid::DistanceGrid(Vec3 low, Vec3 high, const std::function<double(Vec3)>& distance) : low_(low), high_(high) {
    const Vec3 size = high - low;
    step_ = std::max({size.x, size.y, size.z}) / steps;
    count_ = {static_cast<std::size_t>(std::ceil(size.x / step_)) + 1,
              static_cast<std::size_t>(std::ceil(size.y / step_)) + 1,
              static_cast<std::size_t>(std::ceil(size.z / step_)) + 1};
    distances_.reserve(count_[0] * count_[1] * count_[2]);
    for (std::size_t k = 0; k < count_[2]; ++k)
        for (std::size_t j = 0; j < count_[1]; ++j)
            for (std::size_t i = 0; i < count_[0]; ++i)
                distances_.push_back(static_cast<float>(distance(place(i, j, k))));
}

Vec3 DistanceGrid::place(std::size_t i, std::size_t j, std::size_t k) const {
    return low_ + step_ * Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
}

double DistanceGrid::bound(Vec3 p) const {
    const Vec3 outside{std::max({low_.x - p.x, 0.0, p.x - high_.x}), std::max({low_.y - p.y, 0.0, p.y - high_.y}),
                       std::max({low_.z - p.z, 0.0, p.z - high_.z})};
    const double to_box = norm(outside);
    const auto nearest = [this](double from_low, std::size_t count) {
        return static_cast<std::size_t>(std::clamp(std::round(from_low / step_), 0.0, static_cast<double>(count - 1)));
    };
    const Vec3 from_low = p - low_;
    const std::size_t i = nearest(from_low.x, count_[0]), j = nearest(from_low.y, count_[1]),
                      k = nearest(from_low.z, count_[2]);
    const double there = distances_[(k * count_[1] + j) * count_[0] + i];
    constexpr double rounding = 1.0 - 1e-6;  // of the distances that are kept in single precision
    const double least = rounding * std::abs(there) - norm(p - place(i, j, k));
    // Farther out than the box's wall, the solid is at least as far as the wall.
    return least > to_box ? std::copysign(least, there) : to_box;
}

}  // namespace haptogram
