// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/rest.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

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

}  // namespace haptogram::robot
