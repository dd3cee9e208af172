// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// Where something is and how it is turned: its origin and its axes, given in the surrounding frame.
struct Pose {
    Vec3 origin;
    Vec3 x{1.0, 0.0, 0.0}, y{0.0, 1.0, 0.0}, z{0.0, 0.0, 1.0};  ///< of length 1, right-handed

    /// From its own coordinates of a point to those in the surrounding frame; inwards() does the reverse.
    [[nodiscard]] Vec3 outwards(Vec3 p) const { return origin + turned(p); }
    [[nodiscard]] Vec3 inwards(Vec3 p) const;
    /// The same for a direction.
    [[nodiscard]] Vec3 turned(Vec3 d) const { return d.x * x + d.y * y + d.z * z; }
    friend constexpr bool operator==(const Pose&, const Pose&) = default;
};

/// The pose of something that is turned by angles in degrees about the fixed x, then y, then z axis, and then moved.
[[nodiscard]] Pose pose_of(Vec3 origin, Vec3 angles_deg);

}  // namespace haptogram
