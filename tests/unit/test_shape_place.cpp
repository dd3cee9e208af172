// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/shape/tour.hpp"

using namespace haptogram;

namespace {

const Shape two_points{{Cloud{{{1, 2, 3}, {3, 2, 3}}}}};

std::vector<Vec3> points(const Shape& shape) { return std::get<Cloud>(shape.pieces.front()).points; }

void check_same(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CAPTURE(i, a[i].x, a[i].y, a[i].z);
        CHECK(distance(a[i], b[i]) < 1e-12);
    }
}

}  // namespace

TEST_CASE("each step of a placement", "[shape][place]") {
    check_same(points(placed_at(two_points, {})), points(two_points));
    check_same(points(placed_at(two_points, {.scale = 2})), {{2, 4, 6}, {6, 4, 6}});
    check_same(points(placed_at(two_points, {.size_m = 4})), {{0, 2, 3}, {4, 2, 3}});
    check_same(points(placed_at(two_points, {.rotate_deg = {0, 0, 90}})), {{2, 1, 3}, {2, 3, 3}});
    check_same(points(placed_at(two_points, {.rotate_deg = {0, 90, 0}})), {{2, 2, 4}, {2, 2, 2}});
    check_same(points(placed_at(two_points, {.rotate_deg = {90, 0, 0}})), points(two_points));
    check_same(points(placed_at(two_points, {.center = Vec3{0, 0, 0.1}})), {{-1, 0, 0.1}, {1, 0, 0.1}});
}

TEST_CASE("x is turned before y before z, right-handed", "[shape][place]") {
    const Shape corners{{Cloud{{{-1, -1, -1}, {1, 1, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}};
    check_same(points(placed_at(corners, {.rotate_deg = {90, 0, 0}})),
               {{-1, 1, -1}, {1, -1, 1}, {1, 0, 0}, {0, 0, 1}, {0, -1, 0}});
    check_same(points(placed_at(corners, {.rotate_deg = {90, 90, 0}})),
               {{-1, 1, 1}, {1, -1, -1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}});
    check_same(points(placed_at(corners, {.rotate_deg = {90, 90, 90}})),
               {{-1, -1, 1}, {1, 1, -1}, {0, 0, -1}, {0, 1, 0}, {1, 0, 0}});
}

TEST_CASE("the steps come in their order", "[shape][place]") {
    check_same(
        points(placed_at(two_points, {.scale = 10, .size_m = 1, .rotate_deg = {0, 0, 180}, .center = Vec3{0, 0, 5}})),
        {{0.5, 0, 5}, {-0.5, 0, 5}});
}

TEST_CASE("the centre that is moved is that of the turned shape", "[shape][place]") {
    // The box of a turned triangle is not the turned box.
    const Box box = bounding_box(
        placed_at(make_primitive({.kind = "triangle"}), {.rotate_deg = {0, 0, 20}, .center = Vec3{1, 2, 3}}));
    CHECK(distance(box.center(), {1, 2, 3}) < 1e-9);
}

TEST_CASE("curves and meshes are placed like clouds", "[shape][place]") {
    const Placement placement{.scale = 3, .size_m = 0.2, .rotate_deg = {30, 40, 50}, .center = Vec3{0.1, 0.2, 0.3}};
    for (const char* const kind : {"helix", "triangle", "cone"}) {
        CAPTURE(kind);
        const Shape shape = make_primitive({.kind = kind});
        const Shape placed = placed_at(shape, placement);
        CHECK(distance(bounding_box(placed).center(), {0.1, 0.2, 0.3}) < 1e-9);
        const auto before = sample(shape, 50, 1).points;
        const auto after = sample(placed, 50, 1).points;
        const Vec3 extent = bounding_box(shape).extent();
        const double scale = 0.2 / std::max({extent.x, extent.y, extent.z});
        CHECK(distance(after[3], after[40]) == Approx(scale * distance(before[3], before[40])).epsilon(1e-6));
    }
}

TEST_CASE("the box of a curve is exact at its corners and crests", "[shape][place]") {
    const double angle = GENERATE(0.0, 7.0, 29.0, 45.0, 123.0);
    const double r = angle * 0.017453292519943295;
    const Box square =
        bounding_box(placed_at(make_primitive({.kind = "square", .length = 0.1}), {.rotate_deg = {0, 0, angle}}));
    CHECK(square.extent().x == Approx(0.1 * (std::abs(std::cos(r)) + std::abs(std::sin(r)))).epsilon(1e-8));
    const Box circle =
        bounding_box(placed_at(make_primitive({.kind = "circle", .diameter = 0.1}), {.rotate_deg = {angle, 0, angle}}));
    CHECK(circle.extent().z == Approx(0.1 * std::abs(std::sin(r))).epsilon(1e-8));
    const Box line =
        bounding_box(placed_at(make_primitive({.kind = "line", .length = 0.1}), {.rotate_deg = {0, 0, angle}}));
    CHECK(line.extent().y == Approx(0.1 * std::abs(std::sin(r))).epsilon(1e-8));
}

TEST_CASE("vertices of no face do not widen the box", "[shape][place]") {
    const Box box = bounding_box({{Mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}}, {{0, 1, 2}}}}});
    CHECK(box.high == Vec3{1, 1, 0});
}

TEST_CASE("placements that make no sense", "[shape][place]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(placed_at(two_points, {.scale = 0}), Error);
    CHECK_THROWS_AS(placed_at(two_points, {.scale = nan}), Error);
    CHECK_THROWS_AS(placed_at(two_points, {.size_m = -1}), Error);
    CHECK_THROWS_AS(placed_at(two_points, {.rotate_deg = {0, nan, 0}}), Error);
    CHECK_THROWS_AS(placed_at(two_points, {.center = Vec3{0, 0, nan}}), Error);
    CHECK_THROWS_AS(placed_at(make_primitive({.kind = "point"}), {.size_m = 1}), Error);
    CHECK_THROWS_AS(bounding_box({}), Error);
}
