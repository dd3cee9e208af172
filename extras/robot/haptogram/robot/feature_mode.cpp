// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/feature_mode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/contour.hpp"

namespace haptogram::fusion {
namespace {

/// The nearest place of the skin, when it is near enough.
std::optional<Vec3> onto_skin(const std::vector<SkinRegion>& skin, Vec3 point, double farthest) {
    std::optional<Vec3> best;
    for (const SkinRegion& region : skin) {
        const Vec3 place = region.nearest(point).position;
        const double away = distance(place, point);
        if (away > farthest) continue;
        farthest = away;
        best = place;
    }
    return best;
}

}  // namespace

std::vector<Vec3> slice_points(const TouchObject& object, const Hand& hand, const std::vector<SkinRegion>& skin,
                               const SliceOptions& options) {
    if (!(options.corner_m >= 0.0 && options.skin_m >= 0.0))
        throw bad_argument("slice", "distances must not be negative");
    const auto above = [&](Vec3 point) { return dot(point - hand.palm, hand.normal); };
    std::vector<Vec3> points;
    const auto add = [&](Vec3 point) {
        if (const auto place = onto_skin(skin, point, options.skin_m)) points.push_back(*place);
    };
    for (const Edge& edge : object.edges)
        for (std::size_t i = 1; i < edge.size(); ++i) {
            const double from = above(edge[i - 1]), to = above(edge[i]);
            if ((from < 0.0) != (to < 0.0)) add(edge[i - 1] + from / (from - to) * (edge[i] - edge[i - 1]));
        }
    for (const Vec3& corner : object.corners)
        if (std::abs(above(corner)) <= options.corner_m) add(corner);
    return points;
}

std::vector<SkinLine> plane_lines(const std::vector<SkinRegion>& skin, double height_m) {
    const Solid below = half_space({0.0, 0.0, height_m}, {0.0, 0.0, 1.0});
    std::vector<SkinLine> lines;
    for (std::size_t number = 0; number < skin.size(); ++number) {
        const DepthMap map = depth_map(skin[number], below, DepthFor::contour);
        for (SkinLine& line : contours(skin[number], map, 0.0, number, LineKind::contour))
            lines.push_back(std::move(line));
    }
    return lines;
}

std::vector<Vec3> spread(const std::vector<SkinLine>& lines, std::size_t count) {
    const double length = length_of(lines);
    std::vector<Vec3> points;
    if (!(length > 0.0)) return points;
    double passed = 0.0;
    for (const SkinLine& line : lines) {
        const std::vector<SkinPoint> way = opened(line);
        for (std::size_t i = 1; i < way.size(); ++i) {
            const double part = distance(way[i - 1].position, way[i].position);
            while (points.size() < count) {
                const double at = (static_cast<double>(points.size()) + 0.5) / static_cast<double>(count) * length;
                if (at > passed + part) break;
                points.push_back(way[i - 1].position + (at - passed) / part * (way[i].position - way[i - 1].position));
            }
            passed += part;
        }
    }
    return points;
}

robot::Vector3 surface_force(const Surface& surface, const robot::Vector3& position, const robot::Vector3& velocity) {
    if (!(surface.stiffness_n_m > 0.0 && surface.friction >= 0.0 && surface.slow_m_s > 0.0 && surface.texture >= 0.0 &&
          surface.cell_m > 0.0))
        throw bad_argument("surface",
                           "its stiffness, slow speed and cells must be positive, friction and texture not "
                           "negative");
    const double depth = surface.height_m - position.z();
    if (depth <= 0.0) return robot::Vector3::Zero();
    const double normal = surface.stiffness_n_m * depth;
    const robot::Vector3 sliding(velocity.x(), velocity.y(), 0.0);
    robot::Vector3 force = -surface.friction * normal / std::max(sliding.norm(), surface.slow_m_s) * sliding;
    const double turns = 2.0 * std::numbers::pi / surface.cell_m;
    force.x() -= surface.texture * normal * std::sin(turns * position.x());
    force.y() -= surface.texture * normal * std::sin(turns * position.y());
    force.z() = normal;
    return force;
}

Stimulus explore(const TouchObject& object, const Hand& hand, const std::vector<SkinRegion>& skin, double weight_n,
                 const Surface& surface, const robot::Vector3& position, const robot::Vector3& velocity,
                 const SliceOptions& options) {
    Stimulus stimulus;
    stimulus.points = slice_points(object, hand, skin, options);
    stimulus.wrench.head<3>() = surface_force(surface, position, velocity) - weight_n * robot::Vector3::UnitZ();
    return stimulus;
}

}  // namespace haptogram::fusion
