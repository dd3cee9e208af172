// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "haptogram/hand/surface.hpp"
#include "haptogram/live/touch_scene.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

/// The skin of a round finger with a round tip, some 0.7 mm between points. @param along  from the tip backwards
std::vector<Vec3> finger(Vec3 tip, Vec3 along, double radius = 8e-3, double length = 40e-3) {
    const Vec3 level = std::abs(along.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    const Vec3 x = cross(along, level) * (1.0 / norm(cross(along, level))), y = cross(along, x);
    std::vector<Vec3> points;
    constexpr int around = 72;
    const double cap = 0.5 * pi * radius;  // along the skin, from the tip to where the finger is straight
    for (double way = 0.35e-3; way < cap + length; way += 0.7e-3) {
        const double polar = std::min(way / radius, 0.5 * pi);
        const double back = radius * (1.0 - std::cos(polar)) + std::max(0.0, way - cap), r = radius * std::sin(polar);
        for (int i = 0; i < around; ++i) {
            const double turn = 2.0 * pi * i / around;
            points.push_back(tip + back * along + r * (std::cos(turn) * x + std::sin(turn) * y));
        }
    }
    return points;
}

SceneOptions fixed_cube() {
    SceneOptions options;
    options.size_m = 40e-3;
    options.pose.origin = {0, 0, 0.2};
    options.mass_kg = 0.0;
    return options;
}

}  // namespace

TEST_CASE("crossing: beside an edge of a box the normal is that of the face that the finger goes through") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int round = 0; round < 40; ++round) {
        // Into the top face, up to 9 mm deep: its middle is often nearer to the side face, and some of it is outside.
        const double from_edge = 3e-3 + 9e-3 * unit(random), deep = 2e-3 + 7e-3 * unit(random);
        const double y = -6e-3 + 12e-3 * unit(random), turn = 2.0 * pi * unit(random), lean = 0.2 * unit(random);
        const Vec3 tip{20e-3 - from_edge, y, 0.22 - deep};
        const Vec3 back{std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean)};
        INFO(1e3 * from_edge << " mm from the edge, " << 1e3 * deep << " mm deep");
        TouchScene scene(fixed_cube());
        const auto& fingers = scene.update(finger(tip, back), 0.0);
        REQUIRE(fingers.size() == 1);
        CHECK(distance(fingers[0].inward, {0, 0, -1}) < 0.01);
        CHECK(fingers[0].surface.z == Approx(0.22).margin(1e-4));
        CHECK(fingers[0].deepest_m <= deep + 0.2e-3);  // a leaning finger has its lowest point beside its tip
    }
}

TEST_CASE("crossing: a finger that goes in keeps the normal of its face, however near to an edge it goes in") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int round = 0; round < 20; ++round) {
        const double from_edge = 1e-3 + 11e-3 * unit(random), y = -6e-3 + 12e-3 * unit(random);
        const double turn = 2.0 * pi * unit(random), lean = 0.2 * unit(random);
        const Vec3 back{std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean)};
        TouchScene scene(fixed_cube());
        bool touched = false;
        for (int shot = 0; shot <= 10; ++shot) {
            const double deep = 1e-3 * shot;
            INFO(1e3 * from_edge << " mm from the edge, " << 1e3 * deep << " mm deep");
            const auto& fingers = scene.update(finger({20e-3 - from_edge, y, 0.22 - deep}, back), shot / 60.0);
            REQUIRE(fingers.size() <= 1);
            for (const SceneFinger& each : fingers) CHECK(distance(each.inward, {0, 0, -1}) < 0.01);
            touched = touched || !fingers.empty();
        }
        CHECK(touched);
    }
}

TEST_CASE("crossing: of two faces the one counts that more of the finger goes through, not the one with more points") {
    const Solid box = solid_box({}, {0.04, 0.04, 0.04});
    std::vector<Vec3> outside;
    for (int i = 0; i < 12; ++i)  // a ring of 12 points above the top, and 40 in a line beside it
        outside.push_back({5e-3 * std::cos(pi * i / 6), 5e-3 * std::sin(pi * i / 6), 21e-3});
    for (int i = 0; i < 40; ++i) outside.push_back({21e-3, -5e-3 + 0.25e-3 * i, 10e-3 + 1e-5 * (i % 2)});
    const Crossing crossing(box, outside);
    REQUIRE(crossing.inward());
    CHECK(distance(*crossing.inward(), {0, 0, -1}) < 1e-6);
    CHECK(crossing.area({0, 0, -1}) == Approx(12 * 0.5 * 25e-6 * std::sin(pi / 6)).epsilon(1e-3));
    CHECK(crossing.area({-1, 0, 0}) < 1e-7);
    CHECK(crossing.area({0, 0, 1}) == 0.0);
}

TEST_CASE("crossing: a hand that is in the object altogether, and one that is exactly in its middle, get a normal") {
    TouchScene scene(fixed_cube());
    const auto& inside = scene.update(finger({0, 0, 0.195}, {0, 0, 1}, 3e-3, 10e-3), 0.0);
    REQUIRE(inside.size() == 1);
    CHECK(norm(inside[0].inward) == Approx(1.0));
    CHECK(is_finite(inside[0].surface));
    CHECK_FALSE(inward_at(solid_box({}, {2, 2, 2}), {}));
    CHECK_FALSE(inward_at(solid_box({}, {2, 2, 2}), {0.5, 0.5, 0}));  // as far from one face as from another
    CHECK(distance(*inward_at(solid_box({}, {2, 2, 2}), {0.5, 0.1, 0}), {-1, 0, 0}) < 1e-6);
    CHECK_FALSE(Crossing(solid_box({}, {2, 2, 2}), {}).inward());
}

TEST_CASE("crossing: depth along a direction is the way to the surface") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(-0.9, 0.9);
    const Solid box = solid_box({}, {2, 2, 2}), ball = solid_sphere({}, 1.0);
    for (int round = 0; round < 100; ++round) {
        const Vec3 p{place(random), place(random), place(random)};
        CHECK(depth_along(box, p, {-1, 0, 0}) == Approx(1.0 - p.x).margin(1e-5));
        CHECK(depth_along(box, p, {0, 1, 0}) == Approx(1.0 + p.y).margin(1e-5));
        if (norm(p) < 0.95) CHECK(depth_along(ball, p, p * (-1.0 / norm(p))) == Approx(1.0 - norm(p)).margin(1e-5));
    }
    CHECK(depth_along(box, {1.5, 0, 0}, {-1, 0, 0}) == 0.0);
}

TEST_CASE("crossing: on a ball the normal follows a finger that strokes it") {
    SceneOptions options = fixed_cube();
    options.kind = "sphere";
    options.size_m = 60e-3;
    TouchScene scene(options);
    const Vec3 middle{0, 0, 0.2};
    double time = 0.0;
    for (double turn = 0.0; turn < 1.0; turn += 0.08) {
        const Vec3 out{std::sin(turn), 0, std::cos(turn)};
        const auto& fingers = scene.update(finger(middle + (30e-3 - 3e-3) * out, out), time += 1.0 / 30.0);
        REQUIRE(fingers.size() == 1);
        INFO(turn);
        CHECK(fingers[0].id == 1);
        CHECK(dot(fingers[0].inward, -1.0 * out) > 0.98);
        CHECK(std::abs(scene.distance_to(fingers[0].surface)) < 1e-6);
        CHECK(distance(fingers[0].surface, middle + 30e-3 * out) < 5e-3);  // what friction leaves behind
    }
}

TEST_CASE("god-object: a contact that turns keeps the length of its springs, and pushes along the new normal") {
    std::mt19937_64 random(Catch::rngSeed());
    std::normal_distribution<double> normal;
    const auto direction = [&] {
        const Vec3 v{normal(random), normal(random), normal(random)};
        return v * (1.0 / norm(v));
    };
    for (int round = 0; round < 50; ++round) {
        const Pose body = pose_of({0.01, 0.02, 0.2}, {30 * normal(random), 20.0, -15.0});
        const Vec3 before = direction(), after = round == 0 ? -1.0 * before : direction();
        FingerContact contact({}, {0, 0, 0.2}, before, body);
        const Vec3 pushed = Vec3{0, 0, 0.2} + 3e-3 * before;
        const double energy = contact.spring_energy(pushed, body);
        CHECK(energy == Approx(0.5 * 200 * 9e-6));
        contact.turn(pushed, after, body);
        CHECK(contact.spring_energy(pushed, body) == Approx(energy));
        CHECK(distance(contact.inward(body), after) < 1e-9);
        Vec3 force;
        for (const Push& push : contact.pushes(pushed, {}, body, [](Vec3) { return Vec3{}; }))
            force = force + push.force;
        CHECK(distance(force, 0.6 * after) < 1e-6);
    }
}

TEST_CASE("clusters: two halves of a finger are joined, two fingers are not") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int round = 0; round < 20; ++round) {
        const double turn = 2.0 * pi * unit(random), gap = 3.5e-3 + 2e-3 * unit(random);
        const Vec3 tip{-4e-3 + 8e-3 * unit(random), -4e-3 + 8e-3 * unit(random), 0.212}, up{0, 0, 1};
        const Vec3 across{std::cos(turn), std::sin(turn), 0};
        std::vector<Vec3> halves;  // the tip is not seen, nor two stripes along the finger
        for (const Vec3& p : finger(tip, up))
            if (std::abs(dot(p - tip, across)) > 0.5 * gap && p.z > tip.z + 2e-3) halves.push_back(p);
        SceneOptions options = fixed_cube();
        TouchScene scene(options);
        const auto& one = scene.update(halves, 0.0);
        REQUIRE(one.size() == 1);
        const auto section = section_of(one[0].section, one[0].surface, one[0].inward);
        REQUIRE(section);
        CHECK_FALSE(section->constrained);
        CHECK(distance(section->ellipse.centre, {tip.x, tip.y, 0.22}) < 0.5e-3);
        CHECK(section->ellipse.half_minor == Approx(8e-3).epsilon(0.05));
        options.finger_m = 0.0;
        TouchScene parted(options);
        CHECK(parted.update(halves, 0.0).size() == 2);
        std::vector<Vec3> apart = finger(Vec3{0, 0, tip.z} - 9e-3 * across, up, 7e-3);
        const std::vector<Vec3> next = finger(Vec3{0, 0, tip.z} + 9e-3 * across, up, 7e-3);
        apart.insert(apart.end(), next.begin(), next.end());
        TouchScene far(fixed_cube());
        CHECK(far.update(apart, 0.0).size() == 2);
    }
}
