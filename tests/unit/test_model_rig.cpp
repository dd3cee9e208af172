// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"

using namespace haptogram;

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
    REQUIRE(whole.unreachable(focus).empty());
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
    const Array whole = joined(rig);
    REQUIRE_SAID(whole.unreachable(from_mm(0, 0, -50)));
    REQUIRE_SAID(whole.unreachable(rig.arrays[1].pose.outwards(from_mm(5, 5, 15))));
    rig.arrays[1].array.carrier_hz = 25e3;
    REQUIRE_REFUSED(joined(rig));
    REQUIRE_REFUSED(joined(Rig{"none", {}}));
}

TEST_CASE("rig: what one unit cannot reach another one may", "[rig]") {
    const Array cube = joined(find_rig("cube-300"));
    REQUIRE(cube.faces.size() == 4);
    // 35 mm before the left unit's plane, but far off its middle: the right one reaches it.
    const Vec3 far_left = from_mm(-115, -60, 80);
    REQUIRE(cube.unreachable(far_left).empty());
    REQUIRE_SAID(cube.unreachable(from_mm(0, 300, 150)));
    // The same seen from another place.
    const Pose pose = pose_of(from_mm(30, -20, 50), {20, -40, 70});
    const Array moved = seen_from(cube, pose);
    REQUIRE(moved.unreachable(pose.inwards(far_left)).empty());
    REQUIRE_SAID(moved.unreachable(pose.inwards(from_mm(0, 300, 150))));
}

TEST_CASE("rig: the cube's four units face its centre and make a focus there within 0.2 mm", "[rig]") {
    const Rig rig = find_rig("cube-300");
    const Vec3 centre = from_mm(0, 0, 150);
    for (const auto& [array, pose] : rig.arrays) {
        REQUIRE(array.elements.size() == 249);
        REQUIRE(distance(pose.inwards(centre), from_mm(0, 0, 150)) < 1e-15);
    }
    const Array cube = joined(rig);
    REQUIRE(cube.elements.size() == 996);
    for (const Element& element : cube.elements) REQUIRE(dot(element.normal, centre - element.position) > 0.0);
    const Vec3 focus = from_mm(12, -7, 160);
    const auto drives = ideal_drives(cube, focus);
    const auto level = [&](Vec3 p) { return std::norm(pressure(cube, drives, p)); };
    Vec3 peak = focus;
    for (double step = 1e-3; step > 1e-5; step /= 2)
        for (bool better = true; better;) {
            better = false;
            for (const Vec3 way : {Vec3{step, 0, 0}, Vec3{-step, 0, 0}, Vec3{0, step, 0}, Vec3{0, -step, 0},
                                   Vec3{0, 0, step}, Vec3{0, 0, -step}})
                if (level(peak + way) > level(peak)) {
                    peak = peak + way;
                    better = true;
                }
        }
    REQUIRE(distance(peak, focus) < 0.2e-3);
}

TEST_CASE("rig: errors in a file name the line, what was found and what was expected", "[rig]") {
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& text) {
        const auto path = folder.path() / "bad.toml";
        write_file(path, text);
        REQUIRE_REFUSED(load_rig(path));
    };
    const std::string head = "format = \"haptogram-rig-1\"\n";
    const std::string unit = "[[unit]]\narray = \"tile-10x10\"\norigin_mm = [0, 0, 0]\n";
    refused("name = \"x\"\n");
    refused("format = \"haptogram-rig-2\"\n" + unit);
    refused(head);
    refused(head + "unit = 3\n");
    refused(head + unit + "angle = 3\n");
    refused(head + "[[unit]]\norigin_mm = [0, 0, 0]\n");
    refused(head + "[[unit]]\narray = \"tile-10x10\"\n");
    refused(head + "[[unit]]\narray = \"tile-9\"\norigin_mm = [0, 0, 0]\n");
    refused(head + "[[unit]]\narray = \"tile-10x10\"\norigin_mm = [0, 0]\n");
    refused(head + unit + unit);
    refused(head + unit + "[[unit]]\narray = \"hoshi-18x18\"\norigin_mm = [300, 0, 0]\n");
    write_file(folder.path() / "mine.toml", read_file("shipped:arrays/tile-10x10.toml"));
    write_file(folder.path() / "rig.toml",
               head + "[[unit]]\narray = \"mine.toml\"\norigin_mm = [1, 2, 3]\nturn_deg = [0, 180, 0]\n");
    const Rig rig = load_rig(folder.path() / "rig.toml");
    REQUIRE(rig.name == "rig");
    REQUIRE(rig.arrays[0].pose == pose_of(from_mm(1, 2, 3), {0, 180, 0}));
    REQUIRE_REFUSED(find_rig("cube-301"));
}
