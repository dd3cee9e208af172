// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/shape/tour.hpp"

using namespace haptogram;

namespace {

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1p-53; }

Cloud random_cube(std::size_t count, unsigned seed) {
    std::mt19937_64 random(seed);
    Cloud cloud;
    for (std::size_t i = 0; i < count; ++i) cloud.points.push_back({uniform(random), uniform(random), uniform(random)});
    return cloud;
}

double least_distance(const std::vector<Vec3>& points) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) least = std::min(least, distance(points[i], points[j]));
    return least;
}

/// Radius of the largest ball around a point of `surface` that holds none of `points`.
double largest_hole(const std::vector<Vec3>& surface, const std::vector<Vec3>& points) {
    double largest = 0.0;
    for (const Vec3& at : surface) {
        double hole = std::numeric_limits<double>::infinity();
        for (const Vec3& point : points) hole = std::min(hole, distance(at, point));
        largest = std::max(largest, hole);
    }
    return largest;
}

/// Farthest-point sampling as its definition says.
std::vector<std::size_t> farthest_by_definition(const std::vector<Vec3>& candidates, std::size_t count,
                                                std::size_t first) {
    std::vector<std::size_t> chosen{first};
    std::vector<double> gap2(candidates.size(), std::numeric_limits<double>::infinity());
    while (chosen.size() < count) {
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            const Vec3 apart = candidates[i] - candidates[chosen.back()];
            gap2[i] = std::min(gap2[i], dot(apart, apart));
        }
        chosen.push_back(static_cast<std::size_t>(std::max_element(gap2.begin(), gap2.end()) - gap2.begin()));
    }
    return chosen;
}

}  // namespace

TEST_CASE("curves are divided into equal arc lengths", "[shape][sample]") {
    SECTION("closed") {
        const auto points = sample(make_primitive({.kind = "circle", .diameter = 0.07}), 200, 1).points;
        REQUIRE(points.size() == 200);
        const double chord = 0.07 * std::sin(std::numbers::pi / 200);
        for (std::size_t i = 0; i < 200; ++i)
            CHECK(distance(points[i], points[(i + 1) % 200]) == Approx(chord).epsilon(1e-9));
    }
    SECTION("open, with both ends") {
        const auto points = sample(make_primitive({.kind = "line", .length = 0.1}), 101, 1).points;
        REQUIRE(points.size() == 101);
        for (std::size_t i = 0; i < 101; ++i)
            CHECK(points[i].x == Approx(-0.05 + 0.001 * static_cast<double>(i)).margin(1e-15));
    }
    SECTION("one point of a line is its middle") {
        CHECK(norm(sample(make_primitive({.kind = "line"}), 1, 1).points.at(0)) < 1e-12);
    }
    SECTION("by length") {
        Shape shape = make_primitive({.kind = "line", .length = 0.1});
        shape.pieces.push_back(make_primitive({.kind = "circle", .diameter = 0.3 / std::numbers::pi}).pieces.front());
        const auto points = sample(shape, 41, 1).points;  // 10.25 and 30.75 points: the larger remainder gets the last
        CHECK(std::count_if(points.begin(), points.end(),
                            [](Vec3 p) { return std::abs(p.y) < 1e-12 && std::abs(p.x) < 0.0477; }) == 8);
        CHECK(std::count_if(points.begin(), points.end(),
                            [](Vec3 p) { return std::abs(norm(p) - 0.15 / std::numbers::pi) < 1e-9; }) == 31);
    }
    SECTION("the crossing of a plus is felt once") {
        const Sampled sampled = sample(make_primitive({.kind = "plus"}), 202, 1);
        CHECK(sampled.points.size() == 201);
        CHECK(sampled.duplicates_removed == 1);
        CHECK(sample(make_primitive({.kind = "plus"}), 200, 1).points.size() == 200);
    }
}

TEST_CASE("a small cloud is taken whole, in order, each place once", "[shape][sample]") {
    const Shape shape{{Cloud{{{0, 0, 0}, {3, 0, 0}, {1, 0, 0}, {3, 0, 0}, {2, 0, 0}, {-0.0, 0, 0}}}}};
    const Sampled sampled = sample(shape, 6, 1);
    CHECK(sampled.points == std::vector<Vec3>{{0, 0, 0}, {3, 0, 0}, {1, 0, 0}, {2, 0, 0}});
    CHECK(sampled.duplicates_removed == 2);
    CHECK(sample(shape, 4, 1).points == sampled.points);
}

TEST_CASE("the fast farthest-point sampling is the one of the definition", "[shape][sample]") {
    std::vector<Vec3> candidates = random_cube(20'000, 7).points;
    SECTION("in general position") {}
    SECTION("on a grid, where many are equally far") {
        for (Vec3& p : candidates) p = {std::floor(10 * p.x), std::floor(10 * p.y), std::floor(10 * p.z)};
    }
    CHECK(farthest_points(candidates, 500, 17) == farthest_by_definition(candidates, 500, 17));
}

TEST_CASE("surfaces are covered evenly", "[shape][sample]") {
    const auto [kind, area] =
        GENERATE(table<std::string, double>({{"sphere", std::numbers::pi * 0.01},
                                             {"hemisphere", std::numbers::pi * 0.005},
                                             {"cube", 0.06},
                                             {"cylinder", std::numbers::pi * 0.015},
                                             {"cone", std::numbers::pi * 0.0025 * (1.0 + std::sqrt(5.0))}}));
    CAPTURE(kind);
    const std::size_t count = GENERATE(50U, 200U, 400U);
    const Shape shape = make_primitive({.kind = kind});
    const auto points = sample(shape, count, 3).points;
    REQUIRE(points.size() == count);
    // The best there is: a hexagonal lattice, whose points lie `lattice` apart and leave holes of lattice / √3.
    const double lattice = std::sqrt(2.0 / std::sqrt(3.0) * area / static_cast<double>(count));
    CHECK(least_distance(points) > 0.65 * lattice);  // random points come to 0.02
    CHECK(largest_hole(sample(shape, 5000, 99).points, points) < 1.6 * lattice / std::sqrt(3.0));
}

TEST_CASE("a dense cloud is covered evenly", "[shape][sample]") {
    const Cloud cloud = random_cube(20'000, 5);
    const auto points = sample({{cloud}}, 200, 1).points;
    REQUIRE(points.size() == 200);
    CHECK(least_distance(points) > 0.75 * std::cbrt(1.0 / 200));  // random points come to 0.1
    CHECK(largest_hole(cloud.points, points) <= least_distance(points));
    for (const Vec3& point : points)
        CHECK(std::find(cloud.points.begin(), cloud.points.end(), point) != cloud.points.end());
}

TEST_CASE("pieces of different kinds are covered together", "[shape][sample]") {
    Shape shape = make_primitive({.kind = "circle", .diameter = 0.4});
    shape.pieces.push_back(make_primitive({.kind = "cube"}).pieces.front());
    shape.pieces.emplace_back(Cloud{{{0, 0, 1}}});
    const auto points = sample(shape, 100, 1).points;
    REQUIRE(points.size() == 100);
    CHECK(std::count(points.begin(), points.end(), Vec3{0, 0, 1}) == 1);
    CHECK(std::count_if(points.begin(), points.end(), [](Vec3 p) { return std::abs(norm(p) - 0.2) < 1e-9; }) > 10);
    CHECK(std::count_if(points.begin(), points.end(), [](Vec3 p) {
              return std::abs(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 0.05) < 1e-9;
          }) > 10);
}

TEST_CASE("a seed is a choice of points", "[shape][sample]") {
    const Shape shape = make_primitive({.kind = "sphere"});
    const auto points = sample(shape, 100, 42).points;
    CHECK(sample(shape, 100, 42).points == points);
    CHECK(sample(shape, 100, 43).points != points);
}

TEST_CASE("a seed is the same choice on every machine", "[shape][sample]") {
    const Cloud cloud = random_cube(5000, 1);
    std::vector<std::ptrdiff_t> chosen;
    for (const Vec3& point : sample({{cloud}}, 6, 42).points)
        chosen.push_back(std::find(cloud.points.begin(), cloud.points.end(), point) - cloud.points.begin());
    CHECK(chosen == std::vector<std::ptrdiff_t>{2146, 2273, 3775, 4017, 4144, 4209});
}

TEST_CASE("nothing cannot be sampled", "[shape][sample]") {
    CHECK_THROWS_AS(sample(make_primitive({.kind = "circle"}), 0, 1), Error);
    CHECK_THROWS_AS(sample({}, 10, 1), Error);
}
