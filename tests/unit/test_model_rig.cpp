// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/model/rig.hpp"

using namespace haptogram;
using Catch::Contains;

namespace {

Rig two_tiles(double angle_deg) {
    const Array tile = find_array("tile-10x10");
    return {"pair",
            {{tile, pose_of(from_mm(-60, 0, 0), {0, angle_deg, 0})},
             {tile, pose_of(from_mm(60, 0, 0), {0, -angle_deg, 0})}}};
}

}  // namespace

TEST_CASE("rig: a pose turns about x, then y, then z, and the way back undoes it", "[rig]") {
    const Pose pose = pose_of(from_mm(10, 20, 30), {90, 0, 90});
    // About x, y becomes z; about z, x becomes y.
    REQUIRE(distance(pose.turned({0, 1, 0}), {0, 0, 1}) < 1e-15);
    REQUIRE(distance(pose.turned({1, 0, 0}), {0, 1, 0}) < 1e-15);
    std::mt19937_64 g(Catch::rngSeed());
    std::uniform_real_distribution<double> any(-180.0, 180.0);
    for (int i = 0; i < 50; ++i) {
        const Pose some = pose_of({any(g), any(g), any(g)}, {any(g), any(g), any(g)});
        const Vec3 p{any(g), any(g), any(g)};
        REQUIRE(distance(some.inwards(some.outwards(p)), p) < 1e-10);
        REQUIRE(distance(cross(some.x, some.y), some.z) < 1e-12);
    }
}

TEST_CASE("rig: two tilted tiles make at their common focus what each makes in its own frame", "[rig]") {
    const Rig rig = two_tiles(25.0);
    const Array whole = joined(rig);
    REQUIRE(whole.elements.size() == 200);
    const Vec3 focus = from_mm(0, 0, 120);
    REQUIRE(rig.unreachable(focus).empty());
    std::complex<double> alone = 0.0;
    for (const auto& [array, pose] : rig.arrays) {
        const Vec3 seen = pose.inwards(focus);
        alone += pressure(array, ideal_drives(array, seen), seen);
    }
    const std::complex<double> together = pressure(whole, ideal_drives(whole, focus), focus);
    REQUIRE(std::abs(together - alone) < 1e-9 * std::abs(alone));
}

TEST_CASE("rig: the gradient of a tilted rig is the slope of its pressure", "[rig]") {
    const Array whole = joined(two_tiles(40.0));
    const auto drives = ideal_drives(whole, from_mm(5, -3, 110));
    const Vec3 at = from_mm(11, 7, 95);
    const ComplexVec3 gradient = pressure_gradient(whole, drives, at);
    constexpr double step = 1e-6;
    const auto slope = [&](Vec3 way) {
        return (pressure(whole, drives, at + step * way) - pressure(whole, drives, at - step * way)) / (2.0 * step);
    };
    const double size = std::abs(gradient.x) + std::abs(gradient.y) + std::abs(gradient.z);
    REQUIRE(std::abs(gradient.x - slope({1, 0, 0})) < 1e-5 * size);
    REQUIRE(std::abs(gradient.y - slope({0, 1, 0})) < 1e-5 * size);
    REQUIRE(std::abs(gradient.z - slope({0, 0, 1})) < 1e-5 * size);
}

TEST_CASE("rig: what cannot be reached, and arrays that do not go together", "[rig]") {
    Rig rig = two_tiles(0.0);
    REQUIRE_THAT(rig.unreachable(from_mm(0, 0, -50)), Contains("behind"));
    REQUIRE_THAT(rig.unreachable(rig.arrays[1].pose.outwards(from_mm(5, 5, 15))), Contains("nearer"));
    rig.arrays[1].array.carrier_hz = 25e3;
    REQUIRE_THROWS_WITH(joined(rig), Contains("same carrier"));
    REQUIRE_THROWS_WITH(joined(Rig{"none", {}}), Contains("no arrays"));
}
