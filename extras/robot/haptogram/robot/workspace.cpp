// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/workspace.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/tension.hpp"

namespace haptogram::robot {
namespace {

// At which a torque counts as a force. It is short, so that torques are met first: a handle that is moved by a user who
// is stronger than the cables is annoying, and one that turns over is dangerous.
constexpr double arm_m = 0.01;

/// The 26 directions to the faces, edges and corners of a cube.
std::vector<Vector3> directions() {
    std::vector<Vector3> all;
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
                if (x != 0 || y != 0 || z != 0) all.push_back(Vector3(x, y, z).normalized());
    return all;
}

}  // namespace

PerCable nearest_tensions(const Structure& structure, const Wrench& wanted, double least_n, double most_n,
                          const CablesLeft& left, const PerCable& start) {
    // min ½|S·(A·t − w)|² + ½·ε·|t − c|² between the limits, one tension after the other. The second part chooses among
    // the tensions that make the same wrench those that are far from both limits, and keeps the rounds few.
    constexpr double epsilon = 1e-3, settled_n = 1e-4;
    constexpr int most_rounds = 60;
    Structure scaled = structure;
    scaled.bottomRows<3>() /= arm_m;
    Wrench target = wanted;
    target.tail<3>() /= arm_m;
    const double middle = (least_n + most_n) / 2.0;
    PerCable tensions = PerCable::Zero();
    for (int i = 0; i < cable_count; ++i)
        if (left[static_cast<std::size_t>(i)]) tensions[i] = std::clamp(start[i], least_n, most_n);
    Wrench off = scaled * tensions - target;
    for (int round = 0; round < most_rounds; ++round) {
        double moved = 0.0;
        for (int i = 0; i < cable_count; ++i) {
            if (!left[static_cast<std::size_t>(i)]) continue;
            const auto column = scaled.col(i);
            const double slope = column.dot(off) + epsilon * (tensions[i] - middle);
            const double next = std::clamp(tensions[i] - slope / (column.squaredNorm() + epsilon), least_n, most_n);
            off += (next - tensions[i]) * column;
            moved = std::max(moved, std::abs(next - tensions[i]));
            tensions[i] = next;
        }
        if (moved < settled_n) break;
    }
    return tensions;
}

std::optional<double> force_held(const Geometry& geometry, const Pose& pose, const CablesLeft& left) {
    if (!out_of_length(geometry, cable_lengths(geometry, pose)).empty() || !interference(geometry, pose).empty())
        return std::nullopt;
    PerCable least = PerCable::Constant(geometry.least_n), most = PerCable::Constant(geometry.most_n);
    for (int i = 0; i < cable_count; ++i)
        if (!left[static_cast<std::size_t>(i)]) least[i] = most[i] = 0.0;
    const Structure structure = structure_of(geometry, pose);
    const auto holds = [&](const Vector3& force) {
        Wrench wrench = geometry.weight();
        wrench.head<3>() += force;
        return distribute(structure, wrench, least, most).has_value();
    };
    if (!holds(Vector3::Zero())) return std::nullopt;
    constexpr double precise_n = 0.05;
    double held = geometry.most_n * cable_count;  // more than all cables together
    static const std::vector<Vector3> all = directions();
    for (const Vector3& direction : all) {
        if (holds(held * direction)) continue;
        double low = 0.0;
        while (held - low > precise_n) {
            const double force = (low + held) / 2.0;
            (holds(force * direction) ? low : held) = force;
        }
        held = low;
    }
    return held;
}

std::optional<Pose> refuge(const Geometry& geometry, const Pose& here, const CablesLeft& left, double wanted_n) {
    constexpr double step_m = 0.010, farthest_m = 0.080;
    static const std::vector<Vector3> all = directions();
    std::optional<Pose> best;
    double most = -1.0;
    for (double radius = 0.0; radius <= farthest_m; radius += step_m)
        for (const Vector3& direction : all) {
            const Pose place{here.position + radius * direction, Matrix3::Identity()};
            const auto held = force_held(geometry, place, left);
            if (held && *held > most) {
                most = *held;
                best = place;
            }
            if (held && *held >= wanted_n) return place;
            if (radius == 0.0) break;
        }
    return best;
}

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
