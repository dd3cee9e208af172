// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

/// A point of the half-plane in which a solid of revolution has its profile.
struct Profile {
    double r, z;
};

/// A line of the profile.
struct ProfileLine {
    Profile from;
    double er, ez;          ///< to its end
    double inverse_square;  ///< of its length
};

/// Distance to the surface of a convex solid of revolution: the nearest of its profile's lines, negative when the point
/// is on the inner side of all.
double revolved_distance(const std::vector<ProfileLine>& lines, double r, double z) {
    double nearest = std::numeric_limits<double>::infinity();  // squared
    bool inside = true;
    for (const ProfileLine& line : lines) {
        const double pr = r - line.from.r, pz = z - line.from.z;
        const double part = std::clamp((pr * line.er + pz * line.ez) * line.inverse_square, 0.0, 1.0);
        const double dr = pr - part * line.er, dz = pz - part * line.ez;
        nearest = std::min(nearest, dr * dr + dz * dz);
        inside = inside && line.er * pz - line.ez * pr > 0.0;
    }
    return inside ? -std::sqrt(nearest) : std::sqrt(nearest);
}

/// @param corners  of the profile, in the order in which the solid is on the left of the way. Lines that lie on the
/// axis
///                 are no surface, so they are not given
Solid revolved(Vec3 at, const std::vector<Profile>& corners) {
    std::vector<ProfileLine> lines;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
        const double er = corners[i + 1].r - corners[i].r, ez = corners[i + 1].z - corners[i].z;
        lines.push_back({corners[i], er, ez, 1.0 / (er * er + ez * ez)});
    }
    return {[at, lines = std::move(lines)](Vec3 p) {
        const double x = p.x - at.x, y = p.y - at.y;
        return revolved_distance(lines, std::sqrt(x * x + y * y), p.z - at.z);
    }};
}

double segment_distance(Vec3 p, Vec3 a, Vec3 b) {
    const double part = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
    return distance(p, a + part * (b - a));
}

/// Distance to a flat convex face. @param corners  anticlockwise, seen from outside
double face_distance(Vec3 p, const std::vector<Vec3>& corners, Vec3 normal) {
    bool above = true;
    double edges = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3 a = corners[i], b = corners[(i + 1) % corners.size()];
        above = above && dot(cross(normal, b - a), p - a) >= 0.0;
        edges = std::min(edges, segment_distance(p, a, b));
    }
    return above ? std::abs(dot(p - corners.front(), normal)) : edges;
}

}  // namespace

Solid solid_sphere(Vec3 centre, double radius) {
    require_positive("radius", radius);
    return {[=](Vec3 p) { return distance(p, centre) - radius; }};
}

Solid solid_box(Vec3 centre, Vec3 edges) {
    for (const double edge : {edges.x, edges.y, edges.z}) require_positive("edges", edge);
    return {[=](Vec3 p) {
        const Vec3 beyond{std::abs(p.x - centre.x) - 0.5 * edges.x, std::abs(p.y - centre.y) - 0.5 * edges.y,
                          std::abs(p.z - centre.z) - 0.5 * edges.z};
        const Vec3 outside{std::max(beyond.x, 0.0), std::max(beyond.y, 0.0), std::max(beyond.z, 0.0)};
        return norm(outside) + std::min(0.0, std::max({beyond.x, beyond.y, beyond.z}));
    }};
}

Solid half_space(Vec3 point, Vec3 normal) {
    const double length = norm(normal);
    require_positive("normal", length);
    return {[point, n = normal * (1.0 / length)](Vec3 p) { return dot(p - point, n); }};
}

Solid solid_cylinder(Vec3 centre, double radius, double height) {
    require_positive("radius", radius);
    require_positive("height", height);
    return revolved(centre, {{0, -0.5 * height}, {radius, -0.5 * height}, {radius, 0.5 * height}, {0, 0.5 * height}});
}

Solid solid_cone(Vec3 base, double radius, double height) {
    require_positive("radius", radius);
    require_positive("height", height);
    return revolved(base, {{0, 0}, {radius, 0}, {0, height}});
}

Solid solid_pyramid(Vec3 base, double edge, double height) {
    require_positive("edge", edge);
    require_positive("height", height);
    const double h = 0.5 * edge;
    const Vec3 tip = base + Vec3{0, 0, height};
    const std::vector<Vec3> corners{base + Vec3{-h, -h, 0}, base + Vec3{h, -h, 0}, base + Vec3{h, h, 0},
                                    base + Vec3{-h, h, 0}};
    std::vector<std::vector<Vec3>> faces{{corners[3], corners[2], corners[1], corners[0]}};
    for (std::size_t i = 0; i < 4; ++i) faces.push_back({corners[i], corners[(i + 1) % 4], tip});
    std::array<Vec3, 5> normals;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const Vec3 across = cross(faces[i][1] - faces[i][0], faces[i][2] - faces[i][0]);
        normals[i] = across * (1.0 / norm(across));
    }
    // Above the highest plane of a face. Inside a convex solid that is the nearest face, outside the surface is
    // farther.
    const auto above = [points = std::array{faces[0][0], faces[1][0], faces[2][0], faces[3][0], faces[4][0]},
                        normals](Vec3 p) {
        double highest = -std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < points.size(); ++i) highest = std::max(highest, dot(p - points[i], normals[i]));
        return highest;
    };
    return {[above, faces, normals](Vec3 p) {
                if (const double highest = above(p); highest < 0.0) return highest;
                double nearest = std::numeric_limits<double>::infinity();
                for (std::size_t i = 0; i < faces.size(); ++i)
                    if (dot(p - faces[i][0], normals[i]) >= 0.0)  // the nearest face is one that the point sees
                        nearest = std::min(nearest, face_distance(p, faces[i], normals[i]));
                return nearest;
            },
            above};
}

Solid moved(const Solid& solid, Vec3 shift, Vec3 angles_deg) {
    const Pose pose = pose_of(shift, angles_deg);
    Solid result{[distance = solid.distance, pose](Vec3 p) { return distance(pose.inwards(p)); }};
    if (solid.bound) result.bound = [bound = solid.bound, pose](Vec3 p) { return bound(pose.inwards(p)); };
    return result;
}

}  // namespace haptogram
