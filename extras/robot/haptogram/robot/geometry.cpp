// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/geometry.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

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

}  // namespace haptogram::robot
