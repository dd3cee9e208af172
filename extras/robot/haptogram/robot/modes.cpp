// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/contour.hpp"

namespace haptogram::fusion {

SharedClock shared_clock(double period_s, double carrier_hz) {
    constexpr double most_off = 1e-6;  // of a period: far below a tick of the board
    const double periods = period_s * carrier_hz, whole = std::round(periods);
    if (!(carrier_hz > 0.0) || !(whole >= 1.0 && whole <= 1e6) || std::abs(periods - whole) > most_off * whole)
        throw bad_argument("period", fmt::format("a period of the robot must be a whole number of carrier periods, up "
                                                 "to a million; found {:g} s, which are {:.6g} periods of {:g} Hz",
                                                 period_s, periods, carrier_hz));
    return {carrier_hz, static_cast<std::uint32_t>(whole)};
}

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

namespace {

constexpr double pi = std::numbers::pi;

void require_sound(const PalmPattern& pattern, std::size_t points) {
    const bool turns = pattern.sign == PalmSign::rotation, grows = pattern.sign == PalmSign::scaling;
    if ((turns && pattern.shape != PalmShape::line) || (grows && pattern.shape == PalmShape::focus))
        throw bad_argument("sign", "rotation is seen of a line only, and scaling of a line or a ring");
    if (pattern.shape != PalmShape::focus && points < 2)
        throw bad_argument("points", fmt::format("a line or a ring needs at least 2, found {}", points));
    if (!(pattern.size_m > 0.0) || !std::isfinite(pattern.low) || !std::isfinite(pattern.high) ||
        (grows && !(pattern.low > 0.0 && pattern.high > 0.0)))
        throw bad_argument("pattern", "its size, and factors of it, must be positive, and its range finite");
}

}  // namespace

PalmSign palm_sign(const std::string& name) {
    for (const auto& [known, sign] :
         {std::pair("intensity", PalmSign::intensity), std::pair("frequency", PalmSign::frequency),
          std::pair("translation", PalmSign::translation), std::pair("rotation", PalmSign::rotation),
          std::pair("scaling", PalmSign::scaling)})
        if (name == known) return sign;
    throw bad_argument(
        "sign", fmt::format("found \"{}\", expected intensity, frequency, translation, rotation or scaling", name));
}

SignRange usual_range(PalmSign sign) {
    switch (sign) {
        case PalmSign::intensity: return {1.0, 4.0};
        case PalmSign::frequency: return {80.0, 300.0};
        case PalmSign::translation: return {-30e-3, 30e-3};
        case PalmSign::rotation: return {0.0, 90.0};
        case PalmSign::scaling: return {0.5, 2.0};
    }
    throw bad_argument("sign", "is none that a pattern has");
}

PalmShape palm_shape(const std::string& name) {
    for (const auto& [known, shape] :
         {std::pair("focus", PalmShape::focus), std::pair("line", PalmShape::line), std::pair("ring", PalmShape::ring)})
        if (name == known) return shape;
    throw bad_argument("pattern", fmt::format("found \"{}\", expected focus, line or ring", name));
}

Stimulus tell(const PalmPattern& pattern, double value, const Hand& palm, std::size_t points) {
    require_sound(pattern, points);
    if (!(value >= 0.0 && value <= 1.0))
        throw bad_argument("value", fmt::format("a pattern tells values of 0…1, found {:g}", value));
    const double told = pattern.low + value * (pattern.high - pattern.low);
    Stimulus stimulus;
    stimulus.magnitude = pattern.sign == PalmSign::intensity ? told : pattern.magnitude;
    stimulus.frequency_hz = pattern.sign == PalmSign::frequency ? told : pattern.frequency_hz;
    const Vec3 along = palm.direction, across = cross(palm.normal, palm.direction);
    const double shift = pattern.sign == PalmSign::translation ? told : 0.0;
    const double turn = pattern.sign == PalmSign::rotation ? told * pi / 180.0 : 0.0;
    const double half = 0.5 * pattern.size_m * (pattern.sign == PalmSign::scaling ? told : 1.0);
    const auto at = [&](double u, double v) {
        stimulus.points.push_back(palm.palm + (shift + u) * along + v * across);
    };
    if (pattern.shape == PalmShape::focus) {
        at(0.0, 0.0);
        return stimulus;
    }
    for (std::size_t i = 0; i < points; ++i) {
        const auto number = static_cast<double>(i);
        if (pattern.shape == PalmShape::ring) {
            const double angle = 2.0 * pi * number / static_cast<double>(points);
            at(half * std::cos(angle), half * std::sin(angle));
        } else {
            const double place = half * (2.0 * number / static_cast<double>(points - 1) - 1.0);
            at(place * std::cos(turn), place * std::sin(turn));
        }
    }
    return stimulus;
}

double nearness(double distance_m, double range_m) {
    if (!(range_m > 0.0)) throw bad_argument("range", fmt::format("must be above 0 m, found {:g} m", range_m));
    return std::max(0.0, 1.0 - std::abs(distance_m) / range_m);
}

double cloth(double x_m, double y_m, double cell_m) {
    if (!(cell_m > 0.0)) throw bad_argument("cell", fmt::format("must be above 0 m, found {:g} m", cell_m));
    return 0.5 + 0.5 * std::sin(2.0 * pi * x_m / cell_m) * std::sin(2.0 * pi * y_m / cell_m);
}

double hardness(double stiffness_n_m, double softest_n_m, double hardest_n_m) {
    if (!(softest_n_m > 0.0 && softest_n_m < hardest_n_m && stiffness_n_m >= softest_n_m &&
          stiffness_n_m <= hardest_n_m))
        throw bad_argument("stiffness", fmt::format("found {:g} N/m, expected it between the softest, {:g} N/m, and "
                                                    "the hardest, {:g} N/m, that are told",
                                                    stiffness_n_m, softest_n_m, hardest_n_m));
    return std::log(stiffness_n_m / softest_n_m) / std::log(hardest_n_m / softest_n_m);
}

}  // namespace haptogram::fusion
