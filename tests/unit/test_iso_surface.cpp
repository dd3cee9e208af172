// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <utility>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/iso_surface.hpp"

using namespace haptogram;

namespace {

std::vector<double> axis(double from, double to, std::size_t count) {
    std::vector<double> found(count);
    for (std::size_t i = 0; i < count; ++i)
        found[i] = from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1);
    return found;
}

Field volume_of(const std::function<double(Vec3)>& value, Quantity kind = Quantity::rms) {
    Field field;
    field.kind = kind;
    field.region.axes = "xyz";
    field.region.grid = {axis(-0.05, 0.05, 41), axis(-0.05, 0.05, 35), axis(0.05, 0.16, 47)};
    field.parts.emplace_back();
    for (std::size_t i = 0; i < field.region.grid.size(); ++i)
        field.parts[0].push_back(static_cast<float>(value(field.region.grid.point(i))));
    return field;
}

using Place = std::array<double, 3>;

/// How often each edge is walked along, less how often back.
std::map<std::pair<Place, Place>, int> open_edges(const IsoSurface& surface) {
    std::map<std::pair<Place, Place>, int> edges;
    for (const auto& triangle : surface.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 &a = triangle[i], &b = triangle[(i + 1) % 3];
            const Place from{a.x, a.y, a.z}, to{b.x, b.y, b.z};
            if (from < to)
                ++edges[{from, to}];
            else
                --edges[{to, from}];
        }
    std::erase_if(edges, [](const auto& edge) { return edge.second == 0; });
    return edges;
}

const Vec3 centre{0.003, -0.002, 0.1};

}  // namespace

TEST_CASE("surface: of a ball it is the sphere, closed, and faces outwards", "[surface]") {
    const double radius = 0.03;
    // A line through two values is off by at most h² f'' / 8, and h is a cell's diagonal, 4.5 mm at most; divided by
    // the slope.
    const double within = 2.3e-4;
    const Field field = volume_of([&](Vec3 p) { return 1.0 / (1e-4 + dot(p - centre, p - centre)); });
    const IsoSurface surface = iso_surface(field, 1.0 / (1e-4 + radius * radius));
    REQUIRE_FALSE(surface.leaves);
    REQUIRE(surface.triangles.size() > 2000);
    REQUIRE(open_edges(surface).empty());
    double area = 0.0, inside = 0.0;
    for (const auto& [a, b, c] : surface.triangles) {
        for (const Vec3& corner : {a, b, c}) REQUIRE(norm(corner - centre) == Approx(radius).margin(within));
        area += 0.5 * norm(cross(b - a, c - a));
        inside += dot(a - centre, cross(b - centre, c - centre)) / 6.0;
    }
    REQUIRE(area == Approx(4.0 * std::numbers::pi * radius * radius).epsilon(0.01));
    REQUIRE(inside == Approx(4.0 / 3.0 * std::numbers::pi * radius * radius * radius).epsilon(0.01));
}

TEST_CASE(
    "surface: of any field it has no hole but at the volume's edge, and a point of a grid may have just that value",
    "[surface]") {
    std::mt19937 g(Catch::rngSeed());
    std::uniform_int_distribution<int> level(0, 3);
    Field field = volume_of([&](Vec3) { return level(g); });
    Grid& grid = field.region.grid;
    const auto at_edge = [&](std::size_t i) {
        const std::size_t nx = grid.x.size(), ny = grid.y.size(), nz = grid.z.size();
        const std::size_t x = i % nx, y = i / nx % ny, z = i / (nx * ny);
        return x == 0 || y == 0 || z == 0 || x + 1 == nx || y + 1 == ny || z + 1 == nz;
    };
    REQUIRE(iso_surface(field, 1.5).leaves);
    REQUIRE_FALSE(open_edges(iso_surface(field, 1.5)).empty());
    for (std::size_t i = 0; i < grid.size(); ++i)
        if (at_edge(i)) field.parts[0][i] = 0.0F;
    for (const double value : {0.25, 1.0, 1.5, 2.0, 3.0}) {
        const IsoSurface surface = iso_surface(field, value);
        CAPTURE(value);
        REQUIRE_FALSE(surface.leaves);
        REQUIRE(surface.triangles.size() > 1000);
        REQUIRE(open_edges(surface).empty());
    }
    REQUIRE(iso_surface(field, 3.1).triangles.empty());
}

TEST_CASE("surface: so many decibels below the greatest, whatever the quantity", "[surface]") {
    const auto rms = [](Vec3 p) { return 500.0 * std::exp(-dot(p - centre, p - centre) / 2e-4); };
    const double radius = std::sqrt(2e-4 * 6.0 / 20.0 * std::log(10.0));
    for (const auto& [kind, value] : {std::pair<Quantity, std::function<double(Vec3)>>{Quantity::rms, rms},
                                      {Quantity::radiation, [&](Vec3 p) { return 1e-5 * rms(p) * rms(p); }},
                                      {Quantity::level, [&](Vec3 p) { return 20.0 * std::log10(rms(p) / 20e-6); }}}) {
        const IsoSurface surface = surface_below(volume_of(value, kind), 6.0);
        REQUIRE(surface.triangles.size() > 500);
        double mean = 0.0;
        for (const auto& triangle : surface.triangles)
            mean += norm(triangle[0] - centre) / static_cast<double>(surface.triangles.size());
        REQUIRE(mean == Approx(radius).epsilon(0.02));
    }
}

TEST_CASE("surface: where the field is not known it is open", "[surface]") {
    const IsoSurface surface =
        iso_surface(volume_of([&](Vec3 p) { return p.x > 0.01 ? NAN : 0.05 - norm(p - centre); }), 0.02);
    REQUIRE(surface.leaves);
    REQUIRE_FALSE(surface.triangles.empty());
    for (const auto& triangle : surface.triangles)
        for (const Vec3& corner : triangle) REQUIRE(corner.x < 0.0125);
}

TEST_CASE("surface: as STL, in millimetres, and what has none", "[surface]") {
    const IsoSurface surface{1.0, {{Vec3{0.0, 0.0, 0.1}, Vec3{0.001, 0.0, 0.1}, Vec3{0.0, 0.002, 0.1}}}, false};
    const std::string bytes = to_stl(surface);
    REQUIRE(bytes.size() == 84 + 50);
    REQUIRE(bytes.substr(0, 5) != "solid");  // which begins the other kind of STL
    std::array<float, 12> numbers{};
    std::memcpy(numbers.data(), bytes.data() + 84, sizeof numbers);
    REQUIRE(numbers == std::array<float, 12>{0, 0, 1, 0, 0, 100, 1, 0, 100, 0, 2, 100});
    REQUIRE_SAID(description_of(surface));

    Field field = volume_of([](Vec3 p) { return p.z; });
    REQUIRE_REFUSED(surface_below(field, 0.0));
    field.parts.push_back(field.parts.front());
    REQUIRE_REFUSED(iso_surface(field, 0.1));
    field.parts.pop_back();
    field.region.grid.x.resize(1);
    REQUIRE_REFUSED(iso_surface(field, 0.1));
}
