// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

/// A direction at right angles to `axis`, as near to `wanted` as can be.
Vec3 across(Vec3 axis, Vec3 wanted) {
    const Vec3 rest = wanted - dot(wanted, axis) * axis;
    if (norm(rest) > 1e-9) return unit(rest);
    // The finger points along the palm's normal, so no side of it is more palmar than another.
    const Vec3 other = std::abs(axis.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    return unit(other - dot(other, axis) * axis);
}

/// Even steps from one end to the other, both included.
std::size_t steps_over(double length, double cell) { return static_cast<std::size_t>(std::ceil(length / cell)) + 1; }

/// The hemisphere that ends a finger's last segment: rows go on over its end, from the palmar side to the nail's.
/// @param around  cosine and sine of each column's angle from the middle
void add_tip(SkinRegion& region, const std::vector<std::array<double, 2>>& around, double cell) {
    SkinPatch& last = region.patches.back();
    const Vec3 centre = last.from + last.length * last.along;
    const std::size_t rows = steps_over(std::numbers::pi * last.radius, cell);
    for (std::size_t row = 1; row < rows; ++row) {
        const double over = std::numbers::pi * static_cast<double>(row) / static_cast<double>(rows - 1);
        const Vec3 out = std::cos(over) * last.out + std::sin(over) * last.along;
        for (const auto& [cosine, sine] : around) {
            const Vec3 normal = cosine * out + sine * last.side;
            region.points.push_back(centre + last.radius * normal);
            region.normals.push_back(normal);
        }
    }
    region.rows = last.end_row = region.points.size() / region.columns;
    last.tip = true;
}

SkinRegion finger_surface(std::string_view name, const Finger& finger, Vec3 palm_normal, std::array<double, 3> radii,
                          double cell) {
    if (finger.width_m)
        for (const double scale = 0.5 * *finger.width_m / radii[1]; double& radius : radii) radius *= scale;
    SkinRegion region;
    region.name = name;
    const double widest = std::numbers::pi * *std::max_element(radii.begin(), radii.end());
    region.columns = steps_over(widest, cell);
    std::vector<std::array<double, 2>> around;  // cosine and sine of each column's angle from the middle
    for (std::size_t column = 0; column < region.columns; ++column) {
        const double angle =
            std::numbers::pi * (static_cast<double>(column) / static_cast<double>(region.columns - 1) - 0.5);
        around.push_back({std::cos(angle), std::sin(angle)});
    }
    std::size_t most_rows = 0;
    for (std::size_t segment = 0; segment < 3; ++segment)
        most_rows += steps_over(distance(finger.joints.at(segment), finger.joints.at(segment + 1)), cell);
    region.points.reserve(most_rows * region.columns);
    region.normals.reserve(most_rows * region.columns);
    for (std::size_t segment = 0; segment < 3; ++segment) {
        const Vec3 from = finger.joints.at(segment), to = finger.joints.at(segment + 1);
        const double length = distance(from, to), radius = radii.at(segment);
        if (length == 0.0) continue;  // some trackers let two joints of a thumb coincide
        const Vec3 axis = (to - from) * (1.0 / length);
        const Vec3 palmar = across(axis, palm_normal);
        const Vec3 side = cross(axis, palmar);
        const std::size_t rows = steps_over(length, cell);
        for (std::size_t row = region.rows == 0 ? 0 : 1; row < rows; ++row) {
            const Vec3 centre = from + (static_cast<double>(row) / static_cast<double>(rows - 1)) * (to - from);
            for (const auto& [cosine, sine] : around) {
                const Vec3 normal = cosine * palmar + sine * side;
                region.points.push_back(centre + radius * normal);
                region.normals.push_back(normal);
            }
        }
        region.rows = region.points.size() / region.columns;
        region.patches.push_back({from, axis, side, palmar, length, radius, 0.0, 0.0, region.rows, false});
    }
    if (!region.patches.empty()) add_tip(region, around, cell);
    return region;
}

SkinRegion palm_surface(const Hand& hand, const SkinOptions& options) {
    SkinRegion region;
    region.name = "palm";
    region.rows = steps_over(options.palm_length_m, options.cell_m);
    region.columns = steps_over(options.palm_width_m, options.cell_m);
    const Vec3 side = unit(cross(hand.normal, hand.direction));
    region.points.reserve(region.rows * region.columns);
    region.normals.assign(region.rows * region.columns, hand.normal);
    const Vec3 wrist = hand.palm - 0.5 * options.palm_length_m * hand.direction;
    for (std::size_t row = 0; row < region.rows; ++row) {
        const double along = options.palm_length_m * (static_cast<double>(row) / static_cast<double>(region.rows - 1));
        for (std::size_t column = 0; column < region.columns; ++column) {
            const double beside =
                options.palm_width_m * (static_cast<double>(column) / static_cast<double>(region.columns - 1) - 0.5);
            region.points.push_back(wrist + along * hand.direction + beside * side);
        }
    }
    region.patches.push_back({wrist, hand.direction, side, hand.normal, options.palm_length_m, 0.0,
                              options.palm_width_m, options.palm_thickness_m, region.rows, false});
    return region;
}

void require_sound(const Hand& hand) {
    bool finite = is_finite(hand.palm) && is_finite(hand.normal) && is_finite(hand.direction);
    for (const auto& finger : hand.fingers)
        if (finger)
            for (const Vec3& joint : finger->joints) finite = finite && is_finite(joint);
    if (!finite) throw bad_argument("hand", "a coordinate is not finite; correct or leave out this hand");
    if (!(norm(cross(hand.normal, hand.direction)) > 1e-3))
        throw bad_argument("hand",
                           "the palm's normal and the hand's direction are parallel; expected about a right angle");
}

}  // namespace

SkinPoint SkinPatch::nearest(Vec3 point) const {
    const Vec3 way = point - from;
    const Vec3 foot = from + std::clamp(dot(way, along), 0.0, length) * along;
    const double beside = dot(way, side), before = dot(way, out);
    if (const Vec3 beyond = way - length * along; tip && dot(beyond, along) > 0.0) {
        const Vec3 normal = beyond * (1.0 / norm(beyond));
        return {from + length * along + radius * normal, normal};
    }
    if (radius == 0.0) return {foot + std::clamp(beside, -0.5 * width, 0.5 * width) * side, out};
    if (before < 0.0) {
        const Vec3 edge = beside < 0.0 ? -1.0 * side : side;
        return {foot + radius * edge, edge};
    }
    const double away = std::sqrt(beside * beside + before * before);
    const Vec3 normal = away > 0.0 ? (before / away) * out + (beside / away) * side : out;
    return {foot + radius * normal, normal};
}

std::optional<std::array<double, 2>> SkinPatch::clip(Vec3 a, Vec3 b) const {
    double enter = 0.0, leave = 1.0;
    const auto between = [&](Vec3 axis, double low, double high) {
        const double start = dot(a - from, axis), way = dot(b - a, axis);
        if (way == 0.0) {
            if (start < low || start > high) leave = -1.0;
            return;
        }
        const double one = (low - start) / way, other = (high - start) / way;
        enter = std::max(enter, std::min(one, other));
        leave = std::min(leave, std::max(one, other));
    };
    between(along, -radius, length + radius);
    const double half_width = radius > 0.0 ? radius : 0.5 * width;
    between(side, -half_width, half_width);
    const double half_thickness = radius > 0.0 ? radius : 0.5 * thickness;
    between(out, -half_thickness, half_thickness);
    if (enter > leave) return {};
    return std::array{enter, leave};
}

const SkinPatch& SkinRegion::patch(std::size_t row) const {
    return *std::find_if(patches.begin(), patches.end() - 1, [row](const SkinPatch& one) { return row < one.end_row; });
}

SkinPoint SkinRegion::nearest(Vec3 point) const {
    SkinPoint best = patches.front().nearest(point);
    for (const SkinPatch& one : patches)
        if (const SkinPoint found = one.nearest(point);
            distance(found.position, point) < distance(best.position, point))
            best = found;
    return best;
}

std::vector<SkinRegion> palmar_surface(const Hand& hand, const SkinOptions& options) {
    std::vector<double> measures{options.palm_width_m, options.palm_length_m, options.palm_thickness_m, options.cell_m};
    measures.insert(measures.end(), options.finger_radii_m.begin(), options.finger_radii_m.end());
    measures.insert(measures.end(), options.thumb_radii_m.begin(), options.thumb_radii_m.end());
    for (const double measure : measures)
        if (!(measure > 0.0) || !std::isfinite(measure))
            throw bad_argument("hand", fmt::format("a measure of {} m; expected a positive number", measure));
    require_sound(hand);
    constexpr std::array<std::string_view, 5> names{"thumb", "index", "middle", "ring", "pinkie"};
    std::vector<SkinRegion> regions;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (!hand.fingers.at(i)) continue;
        SkinRegion region = finger_surface(names.at(i), *hand.fingers.at(i), hand.normal,
                                           i == 0 ? options.thumb_radii_m : options.finger_radii_m, options.cell_m);
        if (!region.points.empty()) regions.push_back(std::move(region));  // no length, no skin
    }
    regions.push_back(palm_surface(hand, options));
    return regions;
}

}  // namespace haptogram
