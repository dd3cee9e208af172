// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>

#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/kinematics.hpp"

// How the cables that are left bring the handle to rest when one of the eight is gone.

namespace haptogram::robot {

/// Which cables can pull.
using CablesLeft = std::array<bool, cable_count>;

/// The tensions within the limits whose wrench on the handle is nearest to the wanted one, in the sense of least
/// squares; torques count as forces at an arm of 10 mm, and so are met before forces. Seven cables cannot make every
/// wrench, and this is what they can do of it. A cable that is gone has no tension.
/// @param wanted  of the cables on the handle, N and N·m
/// @param start   tensions where the search begins; those of a moment before need the fewest rounds
[[nodiscard]] PerCable nearest_tensions(const Structure& structure, const Wrench& wanted, double least_n, double most_n,
                                        const CablesLeft& left, const PerCable& start);

/// The largest force of a user, N, that the cables that are left hold in every direction in a pose, beside the handle's
/// weight and without torque: the least over 26 directions. @return none when they cannot even hold the weight
[[nodiscard]] std::optional<double> force_held(const Geometry& geometry, const Pose& pose, const CablesLeft& left);

/// A place where the handle can rest on the cables that are left, upright, near to where it is: the nearest that holds
/// `wanted_n` in every direction, or, when there is none within 80 mm, the one that holds most.
/// @return none when it can rest nowhere there
[[nodiscard]] std::optional<Pose> refuge(const Geometry& geometry, const Pose& here, const CablesLeft& left,
                                         double wanted_n);

}  // namespace haptogram::robot
