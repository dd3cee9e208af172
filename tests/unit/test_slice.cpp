// SPDX-License-Identifier: Apache-2.0
// Slices in any direction, against a sum in double precision at points that are written down here.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/field.hpp"
#include "haptogram/verbs/focus_check.hpp"

using namespace haptogram;

namespace {

Excitation two_foci() {
    Excitation excitation = excitation_of(find_array("tile-10x10"), from_mm(10, 0, 130));
    const Excitation other = excitation_of(find_array("tile-10x10"), from_mm(-20, 15, 140));
    excitation.drives.push_back(other.drives.front());
    excitation.weights = {1.0, 3.0};
    return excitation;
}

double mean_square(const Excitation& excitation, Vec3 point) {
    double sum = 0.0, weights = 0.0;
    for (std::size_t r = 0; r < excitation.drives.size(); ++r) {
        sum += excitation.weights[r] * std::norm(pressure(excitation.array, excitation.drives[r], point)) / 2.0;
        weights += excitation.weights[r];
    }
    return sum / weights;
}

void check(const Excitation& excitation, const Slice& slice) {
    const std::vector<float> found = mean_square_on(excitation, slice);
    REQUIRE(found.size() == slice.size());
    double worst = 0.0, peak = 0.0;
    for (std::uint32_t j = 0; j < slice.height; ++j)
        for (std::uint32_t i = 0; i < slice.width; ++i) {
            const double a = double(i) / (slice.width - 1), b = double(j) / (slice.height - 1);
            const Vec3 point{slice.origin.x + a * slice.u.x + b * slice.v.x,
                             slice.origin.y + a * slice.u.y + b * slice.v.y,
                             slice.origin.z + a * slice.u.z + b * slice.v.z};
            const double expected = mean_square(excitation, point);
            peak = std::max(peak, expected);
            worst = std::max(worst, std::abs(found[std::size_t{j} * slice.width + i] - expected));
        }
    INFO("worst " << worst / peak << " of the peak");
    CHECK(worst <= 1e-5 * peak);
}

}  // namespace

TEST_CASE("slice: along each pair of axes, both ways round, and askew") {
    const Excitation excitation = two_foci();
    const Vec3 x = from_mm(80, 0, 0), y = from_mm(0, 60, 0), z = from_mm(0, 0, 50);
    const Vec3 corner = from_mm(-41, -29, 101);
    for (const auto& [u, v] : {std::pair{x, y}, {y, x}, {x, z}, {z, x}, {y, z}, {z, y}})
        check(excitation, {corner, u, v, 23, 17});
    check(excitation, {corner, from_mm(60, 20, 31), from_mm(-10, 55, 7), 19, 21});
    check(excitation, {from_mm(40, 30, 130), from_mm(-80, 0, 0), from_mm(0, -60, 0), 15, 11});
}

TEST_CASE("slice: the same numbers as the field of a region") {
    const Excitation excitation = two_foci();
    Reach reach;
    reach.extent_m = 40e-3;
    reach.step_m = 2e-3;
    const Field whole = field(excitation, parse_region("plane", "xy@z=130", reach), Quantity::rms);
    const std::vector<float> part =
        mean_square_on(excitation, {from_mm(-40, -40, 130), from_mm(80, 0, 0), from_mm(0, 80, 0), 41, 41});
    REQUIRE(whole.parts.front().size() == part.size());
    float peak = 0.0F, worst = 0.0F;
    for (std::size_t i = 0; i < part.size(); ++i) {
        const float square = whole.parts.front()[i] * whole.parts.front()[i];
        peak = std::max(peak, square);
        worst = std::max(worst, std::abs(square - part[i]));
    }
    CHECK(worst <= 1e-5F * peak);
}

TEST_CASE("slice: at places anywhere, the same as on a plane through them") {
    const Excitation excitation = two_foci();
    const Slice slice{from_mm(-20, -10, 120), from_mm(40, 3, 0), from_mm(0, 25, 14), 9, 7};
    const std::vector<float> plane = mean_square_on(excitation, slice);
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < plane.size(); ++i)
        points.push_back(slice.origin + static_cast<double>(i % 9) / 8.0 * slice.u +
                         static_cast<double>(i / 9) / 6.0 * slice.v);
    const std::vector<float> found = mean_square_at(excitation, points);
    REQUIRE(found.size() == plane.size());
    const float peak = *std::max_element(plane.begin(), plane.end());
    for (std::size_t i = 0; i < found.size(); ++i) CHECK(std::abs(found[i] - plane[i]) <= 1e-6F * peak);
    CHECK_REFUSED(mean_square_at(excitation, {}));
    CHECK_REFUSED(mean_square_at(excitation, std::vector<Vec3>(20'001, points[0])));
}

TEST_CASE("slice: what a focus could have at each point is what one has that is made there") {
    const Array array = find_array("tile-10x10");
    std::mt19937 random(Catch::rngSeed());
    std::uniform_real_distribution<double> sideways(-120, 120), up(5, 250), edge(-100, 100);
    std::size_t within = 0, beyond = 0;
    for (int round = 0; round < 8; ++round) {
        const Slice slice{from_mm(sideways(random), sideways(random), up(random)),
                          from_mm(edge(random), edge(random), edge(random)),
                          from_mm(edge(random), edge(random), edge(random)), 5, 4};
        const std::vector<float> found = reachable_on(array, slice);
        REQUIRE(found.size() == 20);
        for (std::size_t i = 0; i < found.size(); ++i) {
            const Vec3 point =
                slice.origin + static_cast<double>(i % 5) / 4.0 * slice.u + static_cast<double>(i / 5) / 3.0 * slice.v;
            if (!array.unreachable(point).empty()) {
                CHECK(found[i] == 0.0F);
                ++beyond;
                continue;
            }
            const Excitation focus = excitation_of(array, point);
            CHECK(found[i] == Approx(mean_square(focus, point)).epsilon(1e-6));
            ++within;
        }
    }
    CHECK(within + beyond == 160);
    const Slice over{from_mm(-10, -10, 150), from_mm(20, 0, 0), from_mm(0, 20, 0), 2, 2};
    for (const float square : reachable_on(array, over)) CHECK(square > 0.0F);
    Slice bad = over;
    bad.width = 1;
    CHECK_REFUSED(reachable_on(array, bad));
}

TEST_CASE("slice: any number of threads gives the same bytes") {
    const Excitation excitation = two_foci();
    const Slice slice{from_mm(-40, -40, 120), from_mm(70, 0, 30), from_mm(0, 80, 0), 60, 50};
    const std::vector<float> one = mean_square_on(excitation, slice, 1);
    CHECK(mean_square_on(excitation, slice, 2) == one);
    CHECK(mean_square_on(excitation, slice, 0) == one);
}

TEST_CASE("slice: sizes and places that make no sense are refused") {
    const Excitation excitation = two_foci();
    const Slice good{from_mm(-40, -40, 120), from_mm(80, 0, 0), from_mm(0, 80, 0), 10, 10};
    for (const std::uint32_t size : {0U, 1U, 2049U, 4294967295U}) {
        Slice slice = good;
        slice.width = size;
        CHECK_REFUSED(mean_square_on(excitation, slice));
        slice = good;
        slice.height = size;
        CHECK_REFUSED(mean_square_on(excitation, slice));
    }
    Slice slice = good;
    slice.u.y = std::nan("");
    CHECK_REFUSED(mean_square_on(excitation, slice));
    slice = good;
    slice.width = slice.height = 2048;
    Excitation many = excitation;
    many.drives.assign(100, excitation.drives.front());
    many.weights.assign(100, 1.0);
    CHECK_REFUSED(mean_square_on(many, slice));
    CHECK_THROWS_AS(mean_square_on(excitation, good, 1, [](double, std::string_view) { return false; }), Error);
}

TEST_CASE("shape of a project: what compile samples, in the array frame") {
    const Project project = project_from_toml(
        "format = \"haptogram-project-1\"\n[place]\nsize_mm = 60\ncenter_mm = [5, -5, 150]\n[[shape]]\nkind = "
        "\"cube\"\n",
        "cube");
    const Shape shape = shape_of(project);
    const Box box = bounding_box(shape);
    CHECK(distance(box.center(), from_mm(5, -5, 150)) < 1e-9);
    CHECK(box.extent().x == Approx(60e-3));
    for (const PathStep& step : compile(project).path.steps) {
        const Vec3 off = step.foci.front().position - box.center();
        CHECK(std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) == Approx(30e-3));
    }
}
