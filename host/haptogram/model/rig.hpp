// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "haptogram/model/array.hpp"

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
};

/// The pose of something that is turned by angles in degrees about the fixed x, then y, then z axis, and then moved.
[[nodiscard]] Pose pose_of(Vec3 origin, Vec3 angles_deg);

/// An array in its place.
struct PosedArray {
    Array array;
    Pose pose;
};

/// Several arrays that play together. Their elements are numbered through: first those of the first array, then those
/// of the second.
struct Rig {
    std::string name;
    std::vector<PosedArray> arrays;

    /// Why a focal point cannot be reached, in words; empty when it can: it must be within reach of at least one array,
    /// and far enough from the elements of all.
    [[nodiscard]] std::string unreachable(Vec3 focus) const;
};

/// All of a rig's elements as one array in the rig's frame, for everything that computes with elements. Its reach is
/// that of the first array alone, so ask the rig what can be reached.
/// @throws Error{bad_argument} when the rig is empty, or its arrays differ in carrier, duty, air or transducer
[[nodiscard]] Array joined(const Rig& rig);

/// The array in the coordinates of a pose: what its elements look like from there. A plane that lies obliquely to the
/// array is an even plane in the coordinates of its own pose, and so is the array's field on it.
[[nodiscard]] Array seen_from(Array array, const Pose& pose);

}  // namespace haptogram
