// SPDX-License-Identifier: Apache-2.0
#include "haptogram/model/rig.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

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

std::string Rig::unreachable(Vec3 focus) const {
    std::string reasons;
    bool reached = false;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
        const auto& [array, pose] = arrays[i];
        const std::string reason = array.unreachable(pose.inwards(focus));
        if (reason.empty()) {
            reached = true;
            continue;
        }
        reasons += fmt::format("{}array {} ({}): {}", reasons.empty() ? "" : "; ", i + 1, array.name, reason);
        for (const Element& element : array.elements)
            if (distance(pose.outwards(element.position), focus) < array.nearest_m) return reasons;
    }
    return reached ? std::string() : reasons;
}

Array joined(const Rig& rig) {
    if (rig.arrays.empty()) throw bad_argument("rig", fmt::format("'{}' has no arrays; give at least one", rig.name));
    Array whole = rig.arrays.front().array;
    whole.name = rig.name;
    whole.elements.clear();
    if (rig.arrays.size() > 1) whole.columns = 0;
    for (const auto& [array, pose] : rig.arrays) {
        if (array.carrier_hz != whole.carrier_hz || array.duty != whole.duty || array.medium != whole.medium ||
            array.transducer != whole.transducer)
            throw bad_argument("rig", fmt::format("'{}': its arrays must have the same carrier, duty, medium and "
                                                  "transducer; {} differs from {}",
                                                  rig.name, array.name, rig.arrays.front().array.name));
        for (const Element& element : array.elements)
            whole.elements.push_back({pose.outwards(element.position), pose.turned(element.normal)});
    }
    return whole;
}

Array seen_from(Array array, const Pose& pose) {
    const Pose straight;
    if (pose.x != straight.x || pose.y != straight.y || pose.z != straight.z) array.columns = 0;
    for (Element& element : array.elements) {
        const Vec3 n = element.normal;
        element.position = pose.inwards(element.position);
        element.normal = {dot(n, pose.x), dot(n, pose.y), dot(n, pose.z)};
    }
    return array;
}

}  // namespace haptogram
