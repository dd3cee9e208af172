// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/kinematics.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::robot {

PerCable cable_lengths(const Geometry& geometry, const Pose& pose) {
    PerCable lengths;
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        lengths[i] = (geometry.anchors[at] - pose.position - pose.rotation * geometry.attachments[at]).norm();
    }
    return lengths;
}

std::string out_of_length(const Geometry& geometry, const PerCable& lengths) {
    for (int i = 0; i < cable_count; ++i)
        if (!(lengths[i] >= geometry.shortest_m && lengths[i] <= geometry.longest_m))
            return fmt::format("cable {} would be {:.1f} mm long; {:g}…{:g} mm are possible", i + 1, lengths[i] * 1e3,
                               geometry.shortest_m * 1e3, geometry.longest_m * 1e3);
    return {};
}

Forward forward(const Geometry& geometry, const PerCable& lengths, const Pose& start,
                const std::array<bool, cable_count>& used) {
    constexpr int most_steps = 50;
    constexpr double settled_m = 1e-7;  // the error after a step is its square over a cable's length: below 1e-13 m
    for (int i = 0; i < cable_count; ++i)
        if (used[static_cast<std::size_t>(i)] && !(lengths[i] > 0.0 && std::isfinite(lengths[i])))
            throw bad_argument("lengths",
                               fmt::format("cable {} must have a positive length, found {:g} m", i + 1, lengths[i]));
    const auto believed = static_cast<int>(std::count(used.begin(), used.end(), true));
    if (believed < 6) throw bad_argument("lengths", fmt::format("six cables at least give a pose, found {}", believed));
    Forward result;
    result.pose = start;
    Eigen::Matrix<double, cable_count, 6> jacobian;
    PerCable residual;
    const auto evaluate = [&] {
        for (int i = 0; i < cable_count; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const Vector3 arm = result.pose.rotation * geometry.attachments[at];
            const Vector3 cable = geometry.anchors[at] - result.pose.position - arm;
            const double weight = used[at] ? 1.0 : 0.0;
            residual[i] = weight * (cable.squaredNorm() - lengths[i] * lengths[i]);
            // The rotation is changed from the left, R ← exp([φ]×)·R, so F changes by −2·(R·b × v)·φ.
            jacobian.block<1, 3>(i, 0) = -2.0 * weight * cable.transpose();
            jacobian.block<1, 3>(i, 3) = -2.0 * weight * arm.cross(cable).transpose();
        }
        result.costs.push_back(residual.squaredNorm() / 2.0);
    };
    evaluate();
    for (bool settled = false; !settled;) {
        if (result.steps == most_steps)
            throw Error(
                ErrorCode::failed, "forward kinematics",
                fmt::format("the pose of these lengths was not found within {} steps; start nearer to it", most_steps));
        const Wrench step = -jacobian.colPivHouseholderQr().solve(residual);
        result.pose.position += step.head<3>();
        result.pose.rotation = rotation_of(step.tail<3>()) * result.pose.rotation;
        ++result.steps;
        evaluate();
        const double arm = geometry.attachments[0].norm();
        settled = step.head<3>().norm() + arm * step.tail<3>().norm() < settled_m;
        if (!step.allFinite())
            throw Error(ErrorCode::failed, "forward kinematics",
                        "the search left all numbers; start nearer to the pose");
    }
    double squares = 0.0;
    const PerCable found = cable_lengths(geometry, result.pose);
    for (int i = 0; i < cable_count; ++i)
        if (used[static_cast<std::size_t>(i)]) squares += std::pow(found[i] - lengths[i], 2);
    result.mismatch_m = std::sqrt(squares / believed);
    return result;
}

Structure structure_of(const Geometry& geometry, const Pose& pose) {
    Structure structure;
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const Vector3 arm = pose.rotation * geometry.attachments[at];
        const Vector3 direction = (geometry.anchors[at] - pose.position - arm).normalized();
        structure.block<3, 1>(0, i) = direction;
        structure.block<3, 1>(3, i) = arm.cross(direction);
    }
    return structure;
}

Wrench pose_deviation(const Geometry& geometry, const Pose& pose, double length_sd_m) {
    // dl = −A·(dr, dφ), so the covariance of the pose is sd²·(AᵀA)⁻¹ with Aᵀ the structure matrix.
    const Structure structure = structure_of(geometry, pose);
    const Eigen::Matrix<double, 6, 6> normal = structure * structure.transpose();
    return length_sd_m * normal.inverse().diagonal().cwiseSqrt();
}

}  // namespace haptogram::robot
