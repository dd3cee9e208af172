// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

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

/// Inverse kinematics: the length of each cable, m: ‖a_i − r − R·b_i‖ (Multimodal eq. 2 and 3; eq. 2 prints a_i·s_i on
/// its left side, where l_i·s_i is meant).
[[nodiscard]] PerCable cable_lengths(const Geometry& geometry, const Pose& pose);

/// Why a pose cannot be taken for the length of a cable, in words; empty when all lie within their limits.
[[nodiscard]] std::string out_of_length(const Geometry& geometry, const PerCable& lengths);

/// Two things that come near each other: cable `first`, and cable `second` or the handle's grip.
struct Nearness {
    int first = 0, second = -1;  ///< 0…7; −1 is the grip
    double distance_m = 0.0;     ///< of the cables' middle lines, or of a cable's middle line and the grip's surface
    double room_m = 0.0;         ///< between their surfaces; negative where they would go through each other
    /// "cables 1 and 5 are 28.71 mm apart"
    [[nodiscard]] std::string words() const;
};
/// Where the cables have the least room among themselves, and beside the grip.
struct Clearance {
    Nearness cables, grip;
    [[nodiscard]] const Nearness& least() const { return cables.room_m < grip.room_m ? cables : grip; }
};
[[nodiscard]] Clearance clearance(const Geometry& geometry, const Pose& pose);

/// Which cables interfere with each other or with the grip in a pose, in words; empty when none do.
[[nodiscard]] std::string interference(const Geometry& geometry, const Pose& pose);

struct Forward {
    Pose pose;
    int steps = 0;
    std::vector<double> costs;  ///< f = ½·ΣF² before each step and at the end, m⁴
    double mismatch_m = 0.0;    ///< root of the mean square of the lengths' differences at the pose
};

/// Forward kinematics: the pose whose cables have these lengths, by the method of Gauss and Newton on
/// F_i = ‖a_i − r − R·b_i‖² − l_i² (Multimodal eq. 4, which counts seven equations; there are eight). With lengths that
/// do not fit together, the pose of least squares.
/// @param start  where the search begins; the handle's last pose, or the centre
/// @param used   which cables to believe; at least six
/// @throws Error{failed} when 50 steps do not settle it, {bad_argument} for lengths that are not positive
[[nodiscard]] Forward forward(const Geometry& geometry, const PerCable& lengths, const Pose& start = {},
                              const std::array<bool, cable_count>& used = {true, true, true, true, true, true, true,
                                                                           true});

/// Aᵀ of Multimodal eq. 15: a column for each cable, its direction s_i and its arm's moment (R·b_i) × s_i, m.
[[nodiscard]] Structure structure_of(const Geometry& geometry, const Pose& pose);

/// How far independent errors of the lengths with this standard deviation spread the pose that forward() finds:
/// standard deviations of x, y, z in m, and of the rotation vector in rad. To first order.
[[nodiscard]] Wrench pose_deviation(const Geometry& geometry, const Pose& pose, double length_sd_m);

}  // namespace haptogram::robot
