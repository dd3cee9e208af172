// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/robot/geometry.hpp"

namespace haptogram::robot {

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
