// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "haptogram/shape/tour.hpp"

using namespace haptogram;

namespace {

/// @param seed  printed by the caller
std::vector<Vec3> random_points(std::size_t count, bool flat, unsigned seed) {
    std::mt19937_64 random(seed);
    const auto uniform = [&] { return static_cast<double>(random() >> 11U) * 0x1p-53; };
    std::vector<Vec3> points(count);
    for (Vec3& p : points) p = {uniform(), uniform(), flat ? 0.0 : uniform()};
    return points;
}

bool is_permutation_from_0(std::vector<std::size_t> order, std::size_t count) {
    if (order.size() != count || (count > 0 && order.front() != 0)) return false;
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < count; ++i)
        if (order[i] != i) return false;
    return true;
}

double nearest_neighbour_length(const std::vector<Vec3>& points) {
    std::vector<std::size_t> left(points.size() - 1);
    std::iota(left.begin(), left.end(), 1U);
    std::vector<std::size_t> order{0};
    while (!left.empty()) {
        const auto next = std::min_element(left.begin(), left.end(), [&](std::size_t a, std::size_t b) {
            return distance(points[a], points[order.back()]) < distance(points[b], points[order.back()]);
        });
        order.push_back(*next);
        left.erase(next);
    }
    return tour_length(points, order);
}

double shortest_length(const std::vector<Vec3>& points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    double shortest = std::numeric_limits<double>::infinity();
    do shortest = std::min(shortest, tour_length(points, order));
    while (std::next_permutation(order.begin() + 1, order.end()));
    return shortest;
}

}  // namespace

TEST_CASE("a tour's length closes the ring", "[shape][tour]") {
    CHECK(tour_length({{0, 0, 0}, {3, 0, 0}, {3, 4, 0}}, {0, 1, 2}) == Approx(12));
    CHECK(tour_length({{0, 0, 0}, {3, 0, 0}}, {0, 1}) == Approx(6));
    CHECK(tour_length({{1, 1, 1}}, {0}) == 0.0);
    CHECK(tour_length({}, {}) == 0.0);
}

TEST_CASE("a tour visits each point once, for any number of points", "[shape][tour]") {
    for (std::size_t count = 0; count < 40; ++count)
        CHECK(is_permutation_from_0(closed_tour(random_points(count, false, 1)), count));
    CHECK(is_permutation_from_0(closed_tour(random_points(3000, false, 2)), 3000));
    CHECK(is_permutation_from_0(closed_tour(std::vector<Vec3>(100, Vec3{1, 2, 3})), 100));
}

TEST_CASE("few points are toured in the shortest way", "[shape][tour]") {
    // 2-opt and Or-opt may stop short of the best; over many small cases they must hardly ever, and never by much.
    int best = 0;
    for (unsigned seed = 1; seed <= 50; ++seed) {
        CAPTURE(seed);
        const auto points = random_points(8, seed % 2 == 0, seed);
        const double ratio = tour_length(points, closed_tour(points)) / shortest_length(points);
        CHECK(ratio < 1.1);
        best += ratio < 1.0 + 1e-9 ? 1 : 0;
    }
    CHECK(best >= 40);
}

TEST_CASE("a tour is shorter than the nearest neighbour's", "[shape][tour]") {
    const unsigned seed = GENERATE(1U, 2U, 3U, 4U, 5U);
    const bool flat = GENERATE(true, false);
    CAPTURE(seed, flat);
    const auto points = random_points(400, flat, seed);
    CHECK(tour_length(points, closed_tour(points)) < 0.95 * nearest_neighbour_length(points));
}

TEST_CASE("tours come near the shortest to be expected", "[shape][tour]") {
    // The shortest tour of 1000 random points in a unit square is 0.7313 √1000 long on average (Johnson and McGeoch
    // 1997).
    double sum = 0.0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const auto points = random_points(1000, true, seed);
        sum += tour_length(points, closed_tour(points));
    }
    const double shortest = 0.7313 * std::sqrt(1000.0);
    CHECK(sum / 10.0 < 1.06 * shortest);  // 2-opt alone comes to 1.074
}

TEST_CASE("no 2-opt move shortens the tour of neighbours", "[shape][tour]") {
    const auto points = random_points(60, true, 9);
    const auto order = closed_tour(points);
    int crossings = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        for (std::size_t j = i + 2; j < order.size(); ++j) {
            const Vec3 a = points[order[i]], b = points[order[i + 1]], c = points[order[j]],
                       d = points[order[(j + 1) % order.size()]];
            crossings += distance(a, c) + distance(b, d) < distance(a, b) + distance(c, d) - 1e-12 ? 1 : 0;
        }
    }
    CHECK(crossings == 0);
}

TEST_CASE("a circle in any order is walked round", "[shape][tour]") {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < 200; ++i) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(i * 77 % 200) / 200.0;
        points.push_back({0.035 * std::cos(angle), 0.035 * std::sin(angle), 0.12});
    }
    CHECK(tour_length(points, closed_tour(points)) ==
          Approx(200 * 0.07 * std::sin(std::numbers::pi / 200)).epsilon(1e-9));
}

TEST_CASE("a grid is walked with few steps askew", "[shape][tour]") {
    std::vector<Vec3> points;
    for (int i = 0; i < 20; ++i)
        for (int j = 0; j < 20; ++j) points.push_back({0.005 * i, 0.005 * j, 0.0});
    const double length = tour_length(points, closed_tour(points));
    CHECK(length > 400 * 0.005 - 1e-9);  // the shortest there is
    CHECK(length < 1.05 * 400 * 0.005);
}

TEST_CASE("the same points give the same tour", "[shape][tour]") {
    const auto points = random_points(500, false, 3);
    CHECK(closed_tour(points) == closed_tour(points));
}
