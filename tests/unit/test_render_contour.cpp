// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/contour.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/touch.hpp"

using namespace haptogram;
using Catch::Contains;

namespace {

constexpr double pi = std::numbers::pi;

/// A palm of 120 × 120 mm without fingers, at a height: a plane.
std::vector<SkinRegion> plane_at(double z) {
    Hand hand;
    hand.palm = {0, 0, z};
    SkinOptions options;
    options.palm_width_m = options.palm_length_m = 0.12;
    return palmar_surface(hand, options);
}

/// Draw frequency of a single closed contour at 7 m/s.
double draw_hz(const Touch& made) { return 1.0 / made.voices.at(0).seconds(); }

}  // namespace

TEST_CASE("contour: a plane through a sphere is a circle of its size", "[render]") {
    struct Expected {
        double height_mm, radius_mm, length_mm;
    };
    const Expected e = GENERATE(Expected{0, 50, 314.16}, Expected{10, 48.990, 307.81}, Expected{20, 45.826, 287.93},
                                Expected{30, 40, 251.33}, Expected{40, 30, 188.50}, Expected{45, 21.794, 136.94});
    CAPTURE(e.height_mm);
    const TouchObject sphere = built_in_object("sphere", {});
    const Touch made = touch_of(Algorithm::intersection, sphere, plane_at(0.2 + e.height_mm * millimetre));
    REQUIRE(made.lines.size() == 1);
    REQUIRE(made.lines[0].closed);
    CHECK(length_of(made.lines) / millimetre == Approx(e.length_mm).epsilon(0.002));
    for (const SkinPoint& point : made.lines[0].points) {
        REQUIRE(std::abs(std::hypot(point.position.x, point.position.y) / millimetre - e.radius_mm) < 0.05);
        REQUIRE(point.normal == Vec3{0, 0, -1});
    }
    CHECK(draw_hz(made) == Approx(7e3 / e.length_mm).epsilon(0.002));
}

TEST_CASE("contour: a cone is cut in circles, and a cube of 100 mm in a square drawn 17.5 times a second", "[render]") {
    struct Expected {
        double height_mm, length_mm, hz;
    };
    const Expected e = GENERATE(Expected{1, 311.02, 22.51}, Expected{25, 235.62, 29.71}, Expected{50, 157.08, 44.56},
                                Expected{75, 78.54, 89.13});
    CAPTURE(e.height_mm);
    ObjectMeasures measures;
    measures.centre = {0, 0, 0.25};  // of the box, so the base is at 200 mm
    const Touch made =
        touch_of(Algorithm::intersection, built_in_object("cone", measures), plane_at(0.2 + e.height_mm * millimetre));
    REQUIRE(made.lines.size() == 1);
    CHECK(length_of(made.lines) / millimetre == Approx(e.length_mm).epsilon(0.002));
    CHECK(draw_hz(made) == Approx(e.hz).epsilon(0.002));
    // At the base itself the depth is 0 everywhere, so its circle is an edge and no contour.
    double base = 0.0;
    const Edge rim = built_in_object("cone", measures).edges.at(0);
    for (std::size_t i = 1; i < rim.size(); ++i) base += distance(rim[i - 1], rim[i]);
    CHECK(base / millimetre == Approx(314.16).epsilon(1e-4));
    CHECK(7.0 / base == Approx(22.28).epsilon(1e-3));
    // The square loses less than a cell at each corner.
    const Touch square = touch_of(Algorithm::intersection, built_in_object("cube", {}), plane_at(0.2));
    REQUIRE(square.lines.size() == 1);
    CHECK(length_of(square.lines) / millimetre == Approx(400).margin(4));
    CHECK(draw_hz(square) == Approx(17.5).epsilon(0.01));
    // Drawn exactly, as the sheet's polygons are.
    for (const auto& [length_mm, hz] :
         {std::pair(400.0, 17.5), {314.159, 22.282}, {251.327, 27.852}, {125.66, 55.70}, {62.83, 111.4}}) {
        const double radius = length_mm * millimetre / (2.0 * pi);
        SkinLine circle{{}, true, LineKind::contour, 0};
        for (int i = 0; i < 3600; ++i)
            circle.points.push_back(
                {{radius * std::cos(2.0 * pi * i / 3600), radius * std::sin(2.0 * pi * i / 3600), 0.2}, {0, 0, -1}});
        CHECK(1.0 / drawn({circle}, Pace{7.0, {}}, Jump::hop).seconds() == Approx(hz).epsilon(5e-4));
    }
}

TEST_CASE("contour: it runs within a cell of the border of the thresholded raster", "[render]") {
    const TouchObject object = built_in_object(GENERATE("sphere", "cube", "cone", "pyramid", "cylinder"), {});
    const auto skin = palmar_surface(synthetic_hand(HandScript::grasp, 0.7, 0.21));
    std::size_t lines = 0;
    for (std::size_t number = 0; number < skin.size(); ++number) {
        const SkinRegion& region = skin[number];
        const DepthMap map = depth_map(region, object.solid, DepthFor::contour);
        // The pruned map tells the sides as the solid does at each point.
        std::vector<bool> inside;
        for (std::size_t i = 0; i < region.points.size(); ++i) {
            inside.push_back(object.solid.contains(region.points[i]));
            REQUIRE((map.depth[i] > 0.0) == inside[i]);
        }
        std::vector<Vec3> border;  // points inside with a neighbour outside
        for (std::size_t row = 0; row < region.rows; ++row)
            for (std::size_t column = 0; column < region.columns; ++column) {
                const auto out = [&](std::size_t r, std::size_t c) {
                    return r < region.rows && c < region.columns && !inside[r * region.columns + c];
                };
                if (inside[row * region.columns + column] &&
                    (out(row + 1, column) || out(row - 1, column) || out(row, column + 1) || out(row, column - 1)))
                    border.push_back(region.point(row, column));
            }
        std::vector<Vec3> contour;
        for (const SkinLine& line : contours(region, map, 0.0, number, LineKind::contour)) {
            ++lines;
            for (const SkinPoint& point : line.points) contour.push_back(point.position);
        }
        const double cell = 1.2e-3;  // a raster of 1 mm, a little more where a finger bends
        for (const auto& [some, others] : {std::pair(border, contour), std::pair(contour, border)})
            for (const Vec3& p : some)
                REQUIRE(std::any_of(others.begin(), others.end(), [&](Vec3 q) { return distance(p, q) < cell; }));
    }
    CHECK(lines > 0);
}

TEST_CASE("contour: closed where it closes, open where it leaves the raster, and the inside on its left", "[render]") {
    // A half-space that cuts the palm along its length leaves one open line.
    ObjectMeasures measures;
    measures.centre = {0.01, 0, 0.2};
    measures.angles_deg = {0, 90, 0};  // the inside is now at x < 10 mm
    const TouchObject half = built_in_object("half-space", measures);
    const auto skin = plane_at(0.2);
    const auto lines = contours(skin[0], depth_map(skin[0], half.solid, DepthFor::contour), 0.0, 0, LineKind::contour);
    REQUIRE(lines.size() == 1);
    CHECK_FALSE(lines[0].closed);
    CHECK(length_of(lines) == Approx(0.12).epsilon(1e-6));
    for (const SkinPoint& point : lines[0].points) CHECK(point.position.x == Approx(0.01).margin(1e-9));
    // Two spheres that nearly touch: saddles are split so that chains never cross or break.
    const Solid pair{[](Vec3 p) {
        return std::min(distance(p, Vec3{-0.02, 0.0, 0.2}), distance(p, Vec3{0.02, 0.0003, 0.2})) - 0.0199;
    }};
    const auto rings = contours(skin[0], depth_map(skin[0], pair, DepthFor::inside), 0.0, 0, LineKind::contour);
    double length = 0.0;
    for (const SkinLine& ring : rings) {
        CHECK(ring.closed);
        length += length_of(ring);
    }
    CHECK(length == Approx(2 * 2 * pi * 0.0199).epsilon(0.01));
    // Whole or nothing.
    CHECK(contours(skin[0], depth_map(skin[0], solid_sphere({0, 0, 0.2}, 0.2), DepthFor::inside), 0.0, 0,
                   LineKind::contour)
              .empty());
    CHECK(contours(skin[0], depth_map(skin[0], solid_sphere({0, 0, 0.5}, 0.1), DepthFor::inside), 0.0, 0,
                   LineKind::contour)
              .empty());
}

TEST_CASE("contour: depths inside are exact, and the deepest point is found", "[render]") {
    const TouchObject object = built_in_object(GENERATE("sphere", "cube", "cone", "pyramid"), {});
    const auto skin = palmar_surface(synthetic_hand(HandScript::press, 0.4, 0.22));
    std::vector<DepthMap> maps;
    double deepest = -INFINITY;
    for (const SkinRegion& region : skin) {
        maps.push_back(depth_map(region, object.solid, DepthFor::inside));
        for (std::size_t i = 0; i < region.points.size(); ++i) {
            const double depth = -object.solid.distance(region.points[i]);
            deepest = std::max(deepest, depth);
            if (depth > 0.0) REQUIRE(maps.back().depth[i] == depth);
        }
    }
    const auto found = deepest_of(skin, maps);
    REQUIRE(found.has_value());
    CHECK(found->depth == deepest);
    CHECK(-object.solid.distance(found->at.position) == deepest);
}
