// SPDX-License-Identifier: Apache-2.0
#include "haptogram/array/pose.hpp"

#include <cmath>
#include <numbers>

namespace haptogram {

Vec3 Pose::inwards(Vec3 p) const {
    const Vec3 from = p - origin;
    return {dot(from, x), dot(from, y), dot(from, z)};
}

Pose pose_of(Vec3 origin, Vec3 angles_deg) {
    constexpr double degree = std::numbers::pi / 180.0;
    const auto turn = [&](Vec3 v) {
        const double a = angles_deg.x * degree, b = angles_deg.y * degree, c = angles_deg.z * degree;
        v = {v.x, v.y * std::cos(a) - v.z * std::sin(a), v.y * std::sin(a) + v.z * std::cos(a)};
        v = {v.x * std::cos(b) + v.z * std::sin(b), v.y, v.z * std::cos(b) - v.x * std::sin(b)};
        return Vec3{v.x * std::cos(c) - v.y * std::sin(c), v.x * std::sin(c) + v.y * std::cos(c), v.z};
    };
    return {origin, turn({1.0, 0.0, 0.0}), turn({0.0, 1.0, 0.0}), turn({0.0, 0.0, 1.0})};
}

}  // namespace haptogram
