// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/workspace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/robot/kinematics.hpp"
#include "haptogram/robot/tension.hpp"

namespace haptogram::robot {

Turns turns_of(const std::string& name) {
    if (name == "none") return Turns::none;
    if (name == "one") return Turns::one_axis;
    if (name == "all") return Turns::all_axes;
    throw bad_argument("turns", fmt::format("expected none, one or all, found '{}'", name));
}

std::vector<Matrix3> rotations(Turns turns, double angle_rad) {
    if (!(angle_rad >= 0.0 && angle_rad < std::numbers::pi / 2.0))
        throw bad_argument("angle", fmt::format("must be at least 0 and less than 90 degrees, found {:g}",
                                                angle_rad * 180.0 / std::numbers::pi));
    std::vector<Matrix3> list;
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                const int turned = std::abs(x) + std::abs(y) + std::abs(z);
                if (turned > (turns == Turns::none ? 0 : turns == Turns::one_axis ? 1 : 3)) continue;
                list.push_back(rotation_xyz(angle_rad * Vector3(x, y, z)));
            }
    return list;
}

double Workspace::ball_radius_m() const { return std::cbrt(3.0 * volume_m3() / (4.0 * std::numbers::pi)); }

Workspace workspace(const Geometry& geometry, double step_m, Turns turns, double angle_rad, const Progress& progress) {
    constexpr double most_points = 1e8;
    if (!(step_m > 0.0 && std::isfinite(step_m)))
        throw bad_argument("step", fmt::format("must be a positive length, found {:g} mm", step_m * 1e3));
    const Vector3 counts = geometry.frame / step_m;
    if (counts.prod() > most_points)
        throw bad_argument(
            "step", fmt::format("{:g} mm would make {:.3g} points; take a coarser step", step_m * 1e3, counts.prod()));
    const std::vector<Matrix3> turned = rotations(turns, angle_rad);
    Workspace result;
    result.step_m = step_m;
    for (int k = 0; k < 3; ++k)
        for (int i = 0; (i + 0.5) * step_m <= geometry.frame[k] + 1e-9; ++i)
            result.axis[k].push_back((i + 0.5) * step_m - geometry.frame[k] / 2.0);
    const Wrench weight = geometry.weight();
    std::size_t row = 0;
    for (const double z : result.axis[2])
        for (const double y : result.axis[1]) {
            for (const double x : result.axis[0]) {
                const bool useful = std::all_of(turned.begin(), turned.end(), [&](const Matrix3& rotation) {
                    return infeasible(geometry, {{x, y, z}, rotation}, weight).empty();
                });
                result.useful.push_back(useful);
                result.count += useful ? 1 : 0;
            }
            progress(static_cast<double>(++row) / static_cast<double>(result.axis[1].size() * result.axis[2].size()));
        }
    return result;
}

}  // namespace haptogram::robot
