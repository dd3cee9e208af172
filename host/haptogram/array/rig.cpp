// SPDX-License-Identifier: Apache-2.0
#include "haptogram/array/rig.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"

namespace haptogram {

Array joined(const Rig& rig) {
    if (rig.arrays.empty()) throw bad_argument("rig", fmt::format("'{}' has no arrays; give at least one", rig.name));
    Array whole = rig.arrays.front().array;
    whole.name = rig.name;
    whole.elements.clear();
    if (rig.arrays.size() > 1) whole.columns = 0;
    whole.file = rig.file;
    for (const auto& [array, pose] : rig.arrays) {
        if (array.carrier_hz != whole.carrier_hz || array.duty != whole.duty || array.medium != whole.medium ||
            array.transducer != whole.transducer || array.reach_angle_rad != whole.reach_angle_rad ||
            array.nearest_m != whole.nearest_m)
            throw bad_argument("rig", fmt::format("'{}': its arrays must have the same carrier, duty, medium, "
                                                  "transducer and reach; {} differs from {}",
                                                  rig.name, array.name, rig.arrays.front().array.name));
        whole.faces.push_back(pose);
        for (const Element& element : array.elements)
            whole.elements.push_back(
                {pose.outwards(element.position), pose.turned(element.normal), element.response, element.weight});
    }
    return whole;
}

Array seen_from(Array array, const Pose& pose) {
    const Pose straight;
    if (pose.x != straight.x || pose.y != straight.y || pose.z != straight.z) array.columns = 0;
    if (array.faces.empty()) array.faces.emplace_back();
    for (Pose& face : array.faces) {
        const auto turned = [&pose](Vec3 d) { return Vec3{dot(d, pose.x), dot(d, pose.y), dot(d, pose.z)}; };
        face = {pose.inwards(face.origin), turned(face.x), turned(face.y), turned(face.z)};
    }
    for (Element& element : array.elements) {
        const Vec3 n = element.normal;
        element.position = pose.inwards(element.position);
        element.normal = {dot(n, pose.x), dot(n, pose.y), dot(n, pose.z)};
    }
    return array;
}

}  // namespace haptogram
