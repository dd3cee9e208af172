// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>

namespace haptogram::robot {

inline constexpr int cable_count = 8;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using PerCable = Eigen::Matrix<double, cable_count, 1>;   ///< lengths in m, or tensions in N
using Wrench = Eigen::Matrix<double, 6, 1>;               ///< force in N, then torque in N·m about the handle's centre
using Structure = Eigen::Matrix<double, 6, cable_count>;  ///< Aᵀ of Multimodal eq. 15

inline constexpr double gravity_m_s2 = 9.80665;

/// Where the handle is and how it is turned. Frame of the robot: origin at its centre, z upwards, metres.
struct Pose {
    Vector3 position = Vector3::Zero();
    Matrix3 rotation = Matrix3::Identity();
};

/// R_z·R_y·R_x of angles in radians: turned about the fixed x, then y, then z axis.
[[nodiscard]] Matrix3 rotation_xyz(const Vector3& angles);
/// The angles of such a rotation; y lies within ± π/2.
[[nodiscard]] Vector3 angles_xyz(const Matrix3& rotation);
/// The rotation about a vector by its length in radians (Rodrigues), and the vector of a rotation, shorter than π.
[[nodiscard]] Matrix3 rotation_of(const Vector3& vector);
[[nodiscard]] Vector3 vector_of(const Matrix3& rotation);

/// A robot: a handle that hangs in a frame by eight cables.
struct Geometry {
    std::string name;
    Vector3 frame = Vector3::Zero();               ///< edges, m
    std::array<Vector3, cable_count> anchors;      ///< a_i: where the cables leave the frame
    std::array<Vector3, cable_count> attachments;  ///< b_i: where they hold the handle, in its own frame
    double shortest_m = 0.0, longest_m = 0.0;      ///< of a cable
    double thickness_m = 0.0;                      ///< diameter of a cable
    double least_n = 0.0, most_n = 0.0;            ///< tension
    double grip_m = 0.0, grip_length_m = 0.0;      ///< of the handle: a rod along its z, round at both ends, that no
                                                   ///< cable may touch; its diameter and length
    double mass_kg = 0.0;                          ///< of the handle
    Vector3 inertia_kg_m2 = Vector3::Zero();       ///< about its own axes

    /// The wrench of the handle's weight.
    [[nodiscard]] Wrench weight() const;
};

/// Reads a robot file (TOML); extras/robot/README.md describes its keys.
/// @throws Error{bad_input} naming file, line and key
[[nodiscard]] Geometry load_geometry(const std::filesystem::path& path);

/// Finds `name` as a path, or among the shipped robots.
[[nodiscard]] Geometry find_geometry(const std::string& name = "cube-390");

/// The same robot with a cubic frame of another edge. @throws Error{bad_argument} naming "edge" when it is not positive
[[nodiscard]] Geometry with_edge(Geometry geometry, double edge_m);

}  // namespace haptogram::robot
