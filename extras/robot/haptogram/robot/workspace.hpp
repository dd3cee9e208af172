// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/robot/geometry.hpp"

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

/// Which turns of the handle a place must allow.
enum class Turns {
    none,      ///< upright only
    one_axis,  ///< upright, and ± the angle about one axis at a time: 7
    all_axes,  ///< every combination of −, 0 and + the angle about the three axes: 27
};
/// "none", "one" or "all". @throws Error{bad_argument} naming "turns"
[[nodiscard]] Turns turns_of(const std::string& name);
[[nodiscard]] std::vector<Matrix3> rotations(Turns turns, double angle_rad);

/// The useful workspace: where the handle can rest, at every one of the turns, with cables within their lengths that
/// touch neither each other nor the grip, and tensions within their limits for its own weight.
struct Workspace {
    double step_m = 0.0;
    std::vector<double> axis[3];  ///< coordinates of the grid along x, y, z
    std::vector<bool> useful;     ///< x fastest, then y, then z
    std::size_t count = 0;        ///< useful points
    /// Each useful point stands for its cube.
    [[nodiscard]] double volume_m3() const { return static_cast<double>(count) * step_m * step_m * step_m; }
    /// Radius of the ball of the same volume.
    [[nodiscard]] double ball_radius_m() const;
};

/// Divides the frame into cubes, from its lowest corner on, and tries the centre of each. A cube whose centre lies
/// outside of the frame is left out.
/// @throws Error{bad_argument} naming "step" or "angle" when they make no sense
[[nodiscard]] Workspace workspace(const Geometry& geometry, double step_m, Turns turns, double angle_rad,
                                  const Progress& progress = {});

}  // namespace haptogram::robot
