// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

Vec3 unit(Vec3 v) { return v * (1.0 / norm(v)); }

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

SkinRegion finger_surface(std::string_view name, const Finger& finger, Vec3 palm_normal, std::array<double, 3> radii,
                          double cell) {
    if (finger.width_m)
        for (const double scale = 0.5 * *finger.width_m / radii[1]; double& radius : radii) radius *= scale;
    SkinRegion region;
    region.name = name;
    const double widest = std::numbers::pi * *std::max_element(radii.begin(), radii.end());
    region.columns = steps_over(widest, cell);
    for (std::size_t segment = 0; segment < 3; ++segment) {
        const Vec3 from = finger.joints.at(segment), to = finger.joints.at(segment + 1);
        const double length = distance(from, to);
        if (length == 0.0) continue;  // some trackers let two joints of a thumb coincide
        const Vec3 axis = (to - from) * (1.0 / length);
        const Vec3 palmar = across(axis, palm_normal);
        const Vec3 side = cross(axis, palmar);
        const std::size_t rows = steps_over(length, cell);
        for (std::size_t row = region.rows == 0 ? 0 : 1; row < rows; ++row) {
            const Vec3 centre = from + (static_cast<double>(row) / static_cast<double>(rows - 1)) * (to - from);
            for (std::size_t column = 0; column < region.columns; ++column) {
                const double angle =
                    std::numbers::pi * (static_cast<double>(column) / static_cast<double>(region.columns - 1) - 0.5);
                const Vec3 normal = std::cos(angle) * palmar + std::sin(angle) * side;
                region.points.push_back(centre + radii.at(segment) * normal);
                region.normals.push_back(normal);
            }
        }
        region.rows = region.points.size() / region.columns;
    }
    return region;
}

SkinRegion palm_surface(const Hand& hand, const SkinOptions& options) {
    SkinRegion region;
    region.name = "palm";
    region.rows = steps_over(options.palm_length_m, options.cell_m);
    region.columns = steps_over(options.palm_width_m, options.cell_m);
    const Vec3 side = cross(hand.normal, hand.direction);
    for (std::size_t row = 0; row < region.rows; ++row) {
        const double along =
            options.palm_length_m * (static_cast<double>(row) / static_cast<double>(region.rows - 1) - 0.5);
        for (std::size_t column = 0; column < region.columns; ++column) {
            const double beside =
                options.palm_width_m * (static_cast<double>(column) / static_cast<double>(region.columns - 1) - 0.5);
            region.points.push_back(hand.palm + along * hand.direction + beside * side);
            region.normals.push_back(hand.normal);
        }
    }
    return region;
}

}  // namespace

std::vector<SkinRegion> palmar_surface(const Hand& hand, const SkinOptions& options) {
    std::vector<double> measures{options.palm_width_m, options.palm_length_m, options.cell_m};
    measures.insert(measures.end(), options.finger_radii_m.begin(), options.finger_radii_m.end());
    measures.insert(measures.end(), options.thumb_radii_m.begin(), options.thumb_radii_m.end());
    for (const double measure : measures)
        if (!(measure > 0.0) || !std::isfinite(measure))
            throw bad_argument("hand", fmt::format("a measure of {} m; expected a positive number", measure));
    constexpr std::array<std::string_view, 5> names{"thumb", "index", "middle", "ring", "pinkie"};
    std::vector<SkinRegion> regions;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (const auto& finger = hand.fingers.at(i))
            regions.push_back(finger_surface(names.at(i), *finger, hand.normal,
                                             i == 0 ? options.thumb_radii_m : options.finger_radii_m, options.cell_m));
    regions.push_back(palm_surface(hand, options));
    return regions;
}

}  // namespace haptogram
