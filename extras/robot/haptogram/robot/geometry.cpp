// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/geometry.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptogram/base/error.hpp"
#include "haptogram/base/shipped.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram::robot {
namespace {

using section::Section;

constexpr double millimetre = 1e-3;

/// Corner `number` of a box of these edges around the origin: bit 2 of the number is the sign of x, bit 1 of y, bit 0
/// of z.
Vector3 corner(const Vector3& edges, int number) {
    const Vector3 signs((number & 4) != 0 ? 1.0 : -1.0, (number & 2) != 0 ? 1.0 : -1.0, (number & 1) != 0 ? 1.0 : -1.0);
    return signs.cwiseProduct(edges) / 2.0;
}

Vector3 read_edges(const Section& section, std::string_view key) {
    const auto list = section.required(section.numbers(key, 3), key, "a list of 3 numbers");
    const Vector3 edges = Vector3(list[0], list[1], list[2]) * millimetre;
    if (!(edges.minCoeff() > 0.0))
        throw bad_input(section.at(key), fmt::format("{} must be three positive edges in mm", section.full(key)));
    return edges;
}

/// Two numbers, the first positive and less than the second.
std::array<double, 2> read_range(const Section& section, std::string_view key) {
    const auto list = section.required(section.numbers(key, 2), key, "a list of 2 numbers");
    if (!(list[0] > 0.0 && list[0] < list[1]))
        throw bad_input(section.at(key), fmt::format("{} must be two positive numbers, the lower first, found {:g} and "
                                                     "{:g}",
                                                     key, list[0], list[1]));
    return {list[0], list[1]};
}

/// The diameter of the handle's grip. The cables end around it, so it must be thinner than the circle through their
/// ends.
double read_grip(const Section& body, const Vector3& handle) {
    const double circle = std::hypot(handle.x(), handle.y());
    const double usual = 0.75 * std::min(handle.x(), handle.y());
    const double grip = body.number("grip_mm", 0.0, 1000.0).value_or(usual / millimetre) * millimetre;
    if (grip >= circle)
        throw bad_input(body.at("grip_mm"),
                        fmt::format("the grip must be thinner than the circle of {:.1f} mm on which the cables end, "
                                    "found {:g} mm",
                                    circle / millimetre, grip / millimetre));
    return grip;
}

}  // namespace

Matrix3 rotation_xyz(const Vector3& angles) {
    using Eigen::AngleAxisd;
    return (AngleAxisd(angles.z(), Vector3::UnitZ()) * AngleAxisd(angles.y(), Vector3::UnitY()) *
            AngleAxisd(angles.x(), Vector3::UnitX()))
        .toRotationMatrix();
}

Vector3 angles_xyz(const Matrix3& rotation) {
    return {std::atan2(rotation(2, 1), rotation(2, 2)), -std::asin(std::clamp(rotation(2, 0), -1.0, 1.0)),
            std::atan2(rotation(1, 0), rotation(0, 0))};
}

Matrix3 rotation_of(const Vector3& vector) {
    const double angle = vector.norm();
    if (angle == 0.0) return Matrix3::Identity();
    return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

Vector3 vector_of(const Matrix3& rotation) {
    const Eigen::AngleAxisd turn(rotation);
    return turn.angle() * turn.axis();
}

Wrench Geometry::weight() const {
    Wrench wrench = Wrench::Zero();
    wrench[2] = -mass_kg * gravity_m_s2;
    return wrench;
}

Geometry load_geometry(const std::filesystem::path& path) {
    const std::string file = path.string();
    const toml::table root = section::parse(path);
    const Section whole(file, root);
    whole.only({"format", "name", "frame_mm", "handle_mm", "connections", "cable_mm", "cable_diameter_mm", "tension_n",
                "handle"});
    const auto format = whole.text("format");
    if (!format || *format != "haptogram-robot-1")
        throw bad_input(whole.at("format"), R"(format must be "haptogram-robot-1")");
    Geometry geometry;
    geometry.name = whole.required(whole.text("name"), "name", "a text in quotes");
    geometry.frame = read_edges(whole, "frame_mm");
    const Vector3 handle = read_edges(whole, "handle_mm");
    const auto connections =
        whole.required(whole.numbers("connections", cable_count), "connections", "a list of 8 numbers of corners");
    std::array<bool, cable_count> taken{};
    for (std::size_t i = 0; i < cable_count; ++i) {
        const double to = connections[i];
        if (to != std::floor(to) || to < 0.0 || to >= cable_count || taken[static_cast<std::size_t>(to)])
            throw bad_input(whole.at("connections"),
                            fmt::format("each corner of the handle, 0 to 7, must stand there once; found {:g}", to));
        taken[static_cast<std::size_t>(to)] = true;
        geometry.anchors[i] = corner(geometry.frame, static_cast<int>(i));
        geometry.attachments[i] = corner(handle, static_cast<int>(to));
    }
    const auto cable = read_range(whole, "cable_mm"), tension = read_range(whole, "tension_n");
    geometry.shortest_m = cable[0] * millimetre;
    geometry.longest_m = cable[1] * millimetre;
    geometry.thickness_m = whole.number("cable_diameter_mm", 0.01, 100.0).value_or(1.0) * millimetre;
    geometry.least_n = tension[0];
    geometry.most_n = tension[1];
    const Section body(file, root, "handle");
    body.only({"mass_kg", "box_mm", "grip_mm"});
    geometry.grip_m = read_grip(body, handle);
    geometry.grip_length_m = handle.z();
    geometry.mass_kg = body.required(body.number("mass_kg", 1e-3, 100.0), "mass_kg", "a mass in kg");
    const Vector3 box = read_edges(body, "box_mm");
    const Vector3 squares = box.cwiseProduct(box);
    geometry.inertia_kg_m2 = geometry.mass_kg / 12.0 * (Vector3::Constant(squares.sum()) - squares);
    return geometry;
}

Geometry find_geometry(const std::string& name) {
    return load_geometry(path_or_shipped(name, "robots", ".toml", "robot"));
}

Geometry with_edge(Geometry geometry, double edge_m) {
    if (!(edge_m > 0.0 && std::isfinite(edge_m)))
        throw bad_argument("edge", fmt::format("must be a positive length, found {:g} m", edge_m));
    geometry.frame = Vector3::Constant(edge_m);
    for (int i = 0; i < cable_count; ++i) geometry.anchors[static_cast<std::size_t>(i)] = corner(geometry.frame, i);
    return geometry;
}

namespace {

struct Segment {
    Vector3 from, to;
};

/// The nearest that two segments come to each other. The second may be a point.
double distance(const Segment& one, const Segment& other) {
    const Vector3 d = one.to - one.from, e = other.to - other.from, between = one.from - other.from;
    const double dd = d.squaredNorm(), ee = e.squaredNorm(), de = d.dot(e);
    const double parallel = dd * ee - de * de;  // 0 when they are: then any place along the first will do
    double s =
        parallel > 1e-12 * dd * ee ? std::clamp((de * e.dot(between) - ee * d.dot(between)) / parallel, 0.0, 1.0) : 0.0;
    const double t = ee > 0.0 ? std::clamp((de * s + e.dot(between)) / ee, 0.0, 1.0) : 0.0;
    s = std::clamp((de * t - d.dot(between)) / dd, 0.0, 1.0);  // of the first, the place nearest to that
    return (between + s * d - t * e).norm();
}

/// The middle line of the grip, whose ends are round.
Segment grip_of(const Geometry& geometry, const Pose& pose) {
    const Vector3 half =
        std::max(0.0, geometry.grip_length_m - geometry.grip_m) / 2.0 * pose.rotation * Vector3::UnitZ();
    return {pose.position - half, pose.position + half};
}

}  // namespace

PerCable cable_lengths(const Geometry& geometry, const Pose& pose) {
    PerCable lengths;
    for (int i = 0; i < cable_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        lengths[i] = (geometry.anchors[at] - pose.position - pose.rotation * geometry.attachments[at]).norm();
    }
    return lengths;
}

std::string out_of_length(const Geometry& geometry, const PerCable& lengths) {
    std::string found;
    for (int i = 0; i < cable_count; ++i)
        if (!(lengths[i] >= geometry.shortest_m && lengths[i] <= geometry.longest_m))
            found += fmt::format("{}cable {} would be {:.1f} mm", found.empty() ? "" : ", ", i + 1, lengths[i] * 1e3);
    if (!found.empty())
        found += fmt::format(" long; {:g}…{:g} mm are possible", geometry.shortest_m * 1e3, geometry.longest_m * 1e3);
    return found;
}

std::string Nearness::words() const {
    if (second < 0)
        return fmt::format("cable {} is {:.2f} mm from the surface of the grip", first + 1, distance_m * 1e3);
    return fmt::format("cables {} and {} are {:.2f} mm apart", first + 1, second + 1, distance_m * 1e3);
}

Clearance clearance(const Geometry& geometry, const Pose& pose) {
    std::array<Segment, cable_count> cables;
    for (std::size_t i = 0; i < cables.size(); ++i)
        cables[i] = {geometry.anchors[i], pose.position + pose.rotation * geometry.attachments[i]};
    const Segment grip = grip_of(geometry, pose);
    Clearance found;
    found.cables.room_m = found.grip.room_m = std::numeric_limits<double>::infinity();
    const auto meet = [](Nearness& least, std::size_t first, int second, double apart, double thickness) {
        if (apart - thickness < least.room_m) least = {static_cast<int>(first), second, apart, apart - thickness};
    };
    for (std::size_t i = 0; i < cables.size(); ++i) {
        meet(found.grip, i, -1, distance(cables[i], grip) - geometry.grip_m / 2.0, geometry.thickness_m / 2.0);
        for (std::size_t j = i + 1; j < cables.size(); ++j)
            meet(found.cables, i, static_cast<int>(j), distance(cables[i], cables[j]), geometry.thickness_m);
    }
    return found;
}

std::string interference(const Geometry& geometry, const Pose& pose) {
    const Nearness near = clearance(geometry, pose).least();
    if (near.room_m >= 0.0) return {};
    return fmt::format("{}, and a cable is {:g} mm thick: they touch", near.words(), geometry.thickness_m * 1e3);
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
                fmt::format(
                    "the pose of these lengths was not found within {} steps; check them, or start nearer to it",
                    most_steps));
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
