// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/shape/tour.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

void check_extent(const PrimitiveSpec& spec, Vec3 extent) {
    CAPTURE(spec.kind);
    const Box box = bounding_box(make_primitive(spec));
    CHECK(norm(box.center()) < 1e-9);
    CHECK(distance(box.extent(), extent) < 1e-9);
}

std::vector<Vec3> points_of(const PrimitiveSpec& spec) { return sample(make_primitive(spec), 500, 1).points; }

double length_of(const PrimitiveSpec& spec) {
    double length = 0.0;
    for (const Piece& piece : make_primitive(spec).pieces) length += std::get<Curve>(piece).length;
    return length;
}

heard::Refusal refusal(const PrimitiveSpec& spec) {
    try {
        (void)make_primitive(spec);
    } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::bad_argument);
        return heard::Refusal(error);
    }
    FAIL("no error for " << spec.kind);
    return {};
}

}  // namespace

TEST_CASE("the defaults are the paper's, centred on the origin", "[shape][primitives]") {
    check_extent({.kind = "point"}, {});
    check_extent({.kind = "line"}, from_mm(100, 0, 0));
    check_extent({.kind = "circle"}, from_mm(70, 70, 0));
    check_extent({.kind = "plus"}, from_mm(100, 100, 0));
    check_extent({.kind = "triangle"}, from_mm(100, 50 * std::sqrt(3.0), 0));
    check_extent({.kind = "square"}, from_mm(100, 100, 0));
    check_extent({.kind = "hemisphere"}, from_mm(100, 100, 50));
}

TEST_CASE("options set the extents", "[shape][primitives]") {
    check_extent({.kind = "line", .length = 0.03}, from_mm(30, 0, 0));
    check_extent({.kind = "square", .length = 0.03}, from_mm(30, 30, 0));
    check_extent({.kind = "polygon", .diameter = 0.08, .sides = 6}, from_mm(80, 40 * std::sqrt(3.0), 0));
    check_extent({.kind = "polygon", .diameter = 0.08, .sides = 4},
                 from_mm(40 * std::sqrt(2.0), 40 * std::sqrt(2.0), 0));
    check_extent({.kind = "sphere", .diameter = 0.06}, from_mm(60, 60, 60));
    check_extent({.kind = "cube", .length = 0.06}, from_mm(60, 60, 60));
    check_extent({.kind = "cone", .diameter = 0.06, .height = 0.02}, from_mm(60, 60, 20));
    check_extent({.kind = "cylinder", .diameter = 0.06, .height = 0.02}, from_mm(60, 60, 20));
    check_extent({.kind = "helix", .diameter = 0.06, .height = 0.02, .turns = 2.0}, from_mm(60, 60, 20));
}

TEST_CASE("curves have their true length and are walked at their length's pace", "[shape][primitives]") {
    CHECK(length_of({.kind = "circle"}) == Approx(0.07 * pi));
    CHECK(length_of({.kind = "plus"}) == Approx(0.2));
    CHECK(length_of({.kind = "triangle"}) == Approx(0.3));
    CHECK(length_of({.kind = "square"}) == Approx(0.4));
    CHECK(length_of({.kind = "polygon"}) == Approx(0.3));
    CHECK(length_of({.kind = "helix", .diameter = 0.1, .height = 0.3, .turns = 2.0}) ==
          Approx(std::hypot(0.2 * pi, 0.3)));
    const std::string kind = GENERATE("line", "circle", "plus", "triangle", "square", "polygon", "helix");
    CAPTURE(kind);
    for (const Piece& piece : make_primitive({.kind = kind}).pieces) {
        const auto& curve = std::get<Curve>(piece);
        constexpr int steps = 20'000;
        double walked = 0.0;
        for (int i = 0; i < steps; ++i)
            walked += distance(curve.at(curve.length * i / steps), curve.at(curve.length * (i + 1) / steps));
        CHECK(walked == Approx(curve.length).epsilon(1e-4));
        CHECK((distance(curve.at(0.0), curve.at(curve.length)) < 1e-12) == curve.closed);
    }
}

TEST_CASE("points lie on the true shape", "[shape][primitives]") {
    const double fine = 0.05 * millimetre;
    for (const Vec3& p : points_of({.kind = "circle"})) {
        CHECK(std::hypot(p.x, p.y) == Approx(0.035).epsilon(1e-12));
        CHECK(p.z == 0.0);
    }
    for (const Vec3& p : points_of({.kind = "sphere"})) CHECK(std::abs(norm(p) - 0.05) < fine);
    for (const Vec3& p : points_of({.kind = "hemisphere"})) CHECK(std::abs(norm(p + from_mm(0, 0, 25)) - 0.05) < fine);
    for (const Vec3& p : points_of({.kind = "cube"}))
        CHECK(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) == Approx(0.05));
    for (const Vec3& p : points_of({.kind = "cylinder"}))
        CHECK((std::abs(std::abs(p.z) - 0.05) < 1e-9 || std::abs(std::hypot(p.x, p.y) - 0.05) < fine));
    for (const Vec3& p : points_of({.kind = "cone"}))
        CHECK((std::abs(p.z + 0.05) < 1e-9 || std::abs(std::hypot(p.x, p.y) - 0.5 * (0.05 - p.z)) < fine));
    for (const Vec3& p : points_of({.kind = "helix"})) CHECK(std::hypot(p.x, p.y) == Approx(0.035));
}

TEST_CASE("surfaces have their true area", "[shape][primitives]") {
    const auto [kind, area] = GENERATE(table<std::string, double>({{"sphere", pi * 0.01},
                                                                   {"hemisphere", pi * 0.005},
                                                                   {"cube", 0.06},
                                                                   {"cylinder", pi * 0.015},
                                                                   {"cone", pi * 0.0025 * (1.0 + std::sqrt(5.0))}}));
    const Shape shape = make_primitive({.kind = kind});
    const Mesh& mesh = std::get<Mesh>(shape.pieces.front());
    double sum = 0.0;
    Vec3 out{};
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 twice = cross(mesh.vertices.at(b) - mesh.vertices.at(a), mesh.vertices.at(c) - mesh.vertices.at(a));
        sum += 0.5 * norm(twice);
        out = out + twice;
    }
    CHECK(sum == Approx(area).epsilon(1e-4));
    if (kind != "hemisphere") CHECK(norm(out) < 1e-12);  // closed, and all triangles wound alike
}

TEST_CASE("what a shape cannot use is an error that says what it takes", "[shape][primitives]") {
    CHECK_REFUSAL(refusal({.kind = "blob"}));
    CHECK_REFUSAL(refusal({.kind = "circle", .length = 0.1}));
    CHECK_REFUSAL(refusal({.kind = "point", .diameter = 0.1}));
    CHECK_REFUSAL(refusal({.kind = "cone", .sides = 4}));
    for (const double bad :
         {0.0, -0.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        CHECK_REFUSAL(refusal({.kind = "circle", .diameter = bad}));
        CHECK_REFUSAL(refusal({.kind = "cube", .length = bad}));
        CHECK_REFUSAL(refusal({.kind = "cone", .height = bad}));
        CHECK_REFUSAL(refusal({.kind = "helix", .turns = bad}));
    }
    for (const unsigned bad : {0U, 2U, 1001U}) CHECK_REFUSAL(refusal({.kind = "polygon", .sides = bad}));
}

TEST_CASE("every kind that is listed can be made", "[shape][primitives]") {
    CHECK(primitive_kinds().size() == 13);
    for (const std::string& kind : primitive_kinds())
        CHECK(sample(make_primitive({.kind = kind}), 12, 1).points.size() == (kind == "point" ? 1 : 12));
}
