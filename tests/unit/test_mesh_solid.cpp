// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/solid.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/hand/touch.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

struct TestMesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A box along the axes; two triangles a side, anticlockwise from outside.
TestMesh box_mesh(Vec3 centre, Vec3 edges) {
    TestMesh mesh;
    for (unsigned i = 0; i < 8; ++i)
        mesh.vertices.push_back(centre + Vec3{((i & 1U) != 0 ? 0.5 : -0.5) * edges.x,
                                              ((i & 2U) != 0 ? 0.5 : -0.5) * edges.y,
                                              ((i & 4U) != 0 ? 0.5 : -0.5) * edges.z});
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

/// A ball with bumps and hollows, of rings and meridians: 2·rings·columns triangles, less those at the poles.
TestMesh bumpy_mesh(Vec3 centre, double radius, double bumps, std::uint32_t rings, std::uint32_t columns) {
    TestMesh mesh;
    const auto at = [&](double u, double v) {
        const double r = radius * (1.0 + bumps * std::sin(5.0 * v) * std::sin(u) * std::sin(u) * std::cos(3.0 * u));
        return centre + r * Vec3{std::sin(u) * std::cos(v), std::sin(u) * std::sin(v), std::cos(u)};
    };
    mesh.vertices.push_back(at(0.0, 0.0));
    for (std::uint32_t i = 1; i < rings; ++i)
        for (std::uint32_t k = 0; k < columns; ++k) mesh.vertices.push_back(at(pi * i / rings, 2.0 * pi * k / columns));
    mesh.vertices.push_back(at(pi, 0.0));
    const auto number = [&](std::uint32_t i, std::uint32_t k) {
        return i == 0       ? 0U
               : i == rings ? static_cast<std::uint32_t>(mesh.vertices.size() - 1)
                            : 1 + (i - 1) * columns + k % columns;
    };
    for (std::uint32_t i = 0; i < rings; ++i)
        for (std::uint32_t k = 0; k < columns; ++k) {
            const auto a = number(i, k), b = number(i + 1, k), c = number(i + 1, k + 1), d = number(i, k + 1);
            if (i + 1 < rings) mesh.triangles.push_back({a, b, c});
            if (i > 0) mesh.triangles.push_back({a, c, d});
            if (i + 1 == rings) mesh.triangles.back() = {a, b, d};
        }
    return mesh;
}

/// Turns of the surface around a point: the sum of the triangles' solid angles (Van Oosterom and Strackee 1983) over
/// 4π.
double winding(const TestMesh& mesh, Vec3 p) {
    double sum = 0.0;
    for (const auto& [i, j, k] : mesh.triangles) {
        const Vec3 a = mesh.vertices[i] - p, b = mesh.vertices[j] - p, c = mesh.vertices[k] - p;
        const double la = norm(a), lb = norm(b), lc = norm(c);
        sum += 2.0 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return sum / (4.0 * pi);
}

/// Distance to a triangle by dense points: never less than the true one, and at most `spacing` more.
double dense_distance(const TestMesh& mesh, Vec3 p, int steps, double& spacing) {
    double nearest = INFINITY;
    spacing = 0.0;
    for (const auto& [i, j, k] : mesh.triangles) {
        const Vec3 a = mesh.vertices[i], u = mesh.vertices[j] - a, v = mesh.vertices[k] - a;
        spacing = std::max({spacing, norm(u) / steps, norm(v) / steps, norm(u - v) / steps});
        for (int m = 0; m <= steps; ++m)
            for (int n = 0; m + n <= steps; ++n)
                nearest = std::min(nearest, distance(p, a + (m / double(steps)) * u + (n / double(steps)) * v));
    }
    return nearest;
}

}  // namespace

TEST_CASE("mesh solid: a box of triangles is the box", "[hand]") {
    const Vec3 centre{0.01, -0.02, 0.2}, edges{0.05, 0.08, 0.03};
    const TestMesh mesh = box_mesh(centre, edges);
    const Solid solid = mesh_solid(mesh.vertices, mesh.triangles), box = solid_box(centre, edges);
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(-0.08, 0.08);
    for (int i = 0; i < 20'000; ++i) {
        const Vec3 p = centre + Vec3{place(random), place(random), place(random)};
        REQUIRE(solid.distance(p) == Approx(box.distance(p)).margin(1e-12));
    }
    CHECK(std::abs(solid.distance(mesh.vertices[3])) < 1e-15);
}

TEST_CASE("mesh solid: side, distance and bound of a bumpy ball are those of its triangles", "[hand]") {
    const TestMesh mesh = bumpy_mesh({0.0, 0.0, 0.2}, 0.05, 0.35, 18, 30);
    const Solid solid = mesh_solid(mesh.vertices, mesh.triangles);
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(-0.08, 0.08);
    std::size_t inside = 0, bounded = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec3 p{place(random), place(random), 0.2 + place(random)};
        const double turns = winding(mesh, p), d = solid.distance(p);
        CAPTURE(p.x, p.y, p.z, turns, d);
        REQUIRE(solid.contains(p) == (turns > 0.5));
        inside += turns > 0.5 ? 1 : 0;
        double spacing = 0.0;
        const double dense = dense_distance(mesh, p, 12, spacing);
        const double bound = solid.bound(p);
        REQUIRE(std::abs(bound) <= std::abs(d));
        REQUIRE(bound * d >= 0.0);
        bounded += std::abs(bound) > 0.5 * std::abs(d) ? 1 : 0;
        REQUIRE(std::abs(d) <= dense + 1e-12);
        REQUIRE(std::abs(d) >= dense - spacing);
    }
    CHECK(inside > 10);
    CHECK(bounded > 100);  // a bound that is always 0 would be none
    CHECK(solid.bound({1.0, 0.0, 0.2}) > 0.9);
}

TEST_CASE("mesh solid: surfaces that bound no solid are refused, with what is wrong", "[hand]") {
    TestMesh mesh = box_mesh({}, {0.1, 0.1, 0.1});
    SECTION("vertices that a file repeats for each triangle are one") {
        TestMesh loose;
        for (const auto& triangle : mesh.triangles)
            for (const std::uint32_t corner : triangle) loose.vertices.push_back(mesh.vertices[corner]);
        for (std::uint32_t i = 0; i < loose.vertices.size(); i += 3) loose.triangles.push_back({i, i + 1, i + 2});
        CHECK(mesh_solid(loose.vertices, loose.triangles).distance({0.0, 0.0, 0.06}) == Approx(0.01));
    }
    SECTION("a hole") {
        mesh.triangles.pop_back();
        REQUIRE_REFUSED(mesh_solid(mesh.vertices, mesh.triangles));
    }
    SECTION("one triangle the other way round") {
        std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
        REQUIRE_REFUSED(mesh_solid(mesh.vertices, mesh.triangles));
    }
    SECTION("inside out") {
        for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
        REQUIRE_REFUSED(mesh_solid(mesh.vertices, mesh.triangles));
    }
    SECTION("flat") {
        for (Vec3& vertex : mesh.vertices) vertex.z = 0.0;
        REQUIRE_THROWS_AS(mesh_solid(mesh.vertices, mesh.triangles), Error);
    }
    SECTION("nothing") { REQUIRE_REFUSED(mesh_solid({}, {})); }
    SECTION("not a number") {
        mesh.vertices[2].y = std::numeric_limits<double>::quiet_NaN();
        REQUIRE_REFUSED(mesh_solid(mesh.vertices, mesh.triangles));
    }
    SECTION("a corner that is no vertex") {
        mesh.triangles[0][0] = 8;
        REQUIRE_REFUSED(mesh_solid(mesh.vertices, mesh.triangles));
    }
}

TEST_CASE("objects: features are as many as the shape has", "[hand]") {
    struct Expected {
        const char* kind;
        std::size_t edges, corners;
    };
    const Expected e = GENERATE(Expected{"cube", 12, 8}, Expected{"pyramid", 8, 5}, Expected{"cone", 1, 1},
                                Expected{"cylinder", 2, 0}, Expected{"sphere", 0, 0}, Expected{"half-space", 0, 0});
    CAPTURE(e.kind);
    ObjectMeasures measures;
    measures.angles_deg = {20, 30, 40};
    const TouchObject object = built_in_object(e.kind, measures);
    REQUIRE(object.edges.size() == e.edges);
    REQUIRE(object.corners.size() == e.corners);
    // Features lie on the surface.
    for (const Edge& edge : object.edges)
        for (const Vec3& p : edge) REQUIRE(std::abs(object.solid.distance(p)) < 1e-12);
    for (const Vec3& p : object.corners) REQUIRE(std::abs(object.solid.distance(p)) < 1e-12);
    REQUIRE_REFUSED(built_in_object("torus", measures));
    measures.size = -1.0;
    REQUIRE_REFUSED(built_in_object(e.kind, measures));
}

TEST_CASE("objects: a mesh has the edges and corners of its shape", "[hand]") {
    const TestMesh mesh = box_mesh({0, 0, 0.2}, {0.1, 0.06, 0.08});
    const TouchObject box = mesh_object("box", mesh.vertices, mesh.triangles);
    REQUIRE(box.edges.size() == 12);
    REQUIRE(box.corners.size() == 8);
    double length = 0.0;
    for (const Edge& edge : box.edges)
        for (std::size_t i = 1; i < edge.size(); ++i) length += distance(edge[i - 1], edge[i]);
    CHECK(length == Approx(4 * (0.1 + 0.06 + 0.08)));
    const TestMesh ball = bumpy_mesh({}, 0.05, 0.0, 40, 80);
    CHECK(mesh_object("ball", ball.vertices, ball.triangles).edges.empty());
}

TEST_CASE("mesh solid: the time of a frame hardly grows with the triangles", "[hand]") {
    // `make bench` measures the milliseconds; this holds on any processor.
    const auto algorithm = GENERATE(Algorithm::intersection, Algorithm::features_intersection);
    const auto frames_s = [&](std::uint32_t rings) {
        const TestMesh mesh = bumpy_mesh({0.0, 0.0, 0.2}, 0.05, 0.2, rings, rings);
        const TouchObject object = mesh_object("ball", mesh.vertices, mesh.triangles);
        double total_s = 0.0;
        for (int i = 0; i < 10; ++i) {
            const auto skin = palmar_surface(synthetic_hand(HandScript::press, 0.1 * i, 0.22));
            double best_s = INFINITY;  // of five: the machine may have other work
            for (int k = 0; k < 5; ++k) {
                const std::clock_t begin = std::clock();
                const Touch made = touch_of(algorithm, object, skin, 0.1 * i);
                best_s = std::min(best_s, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
                REQUIRE_FALSE(made.lines.empty());
            }
            total_s += best_s;
        }
        return total_s;
    };
    const double few = frames_s(56), many = frames_s(225);  // 6,160 and 100,800 triangles
    CHECK(many <= 3.0 * few);
}
