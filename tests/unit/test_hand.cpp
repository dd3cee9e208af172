// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/solid.hpp"
#include "haptogram/hand/surface.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

/// Recordings of real hands that are not part of the repository, in a folder beside it.
std::filesystem::path recordings() {
    return std::filesystem::path(test_data()).parent_path().parent_path().parent_path() / "shared/data/leap";
}

/// The least of a convex function along a line from a to b.
double least_along(const Solid& solid, Vec3 a, Vec3 b) {
    double from = 0.0, to = 1.0;
    const auto value = [&](double part) { return solid.distance(a + part * (b - a)); };
    for (int i = 0; i < 60; ++i) {
        const double part = (to - from) / (1.0 + std::numbers::phi);
        if (value(from + part) > value(to - part))
            from += part;
        else
            to -= part;
    }
    return std::min({value(0.0), value(1.0), value(0.5 * (from + to))});
}

/// How much of a line lies in a box, by its slabs.
double length_in_box(Vec3 a, Vec3 b, Vec3 centre, double edge) {
    double from = 0.0, to = 1.0;
    for (double Vec3::*const axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
        const double start = a.*axis - centre.*axis, way = b.*axis - a.*axis;
        if (way == 0.0) {
            if (std::abs(start) > 0.5 * edge) return 0.0;
            continue;
        }
        const double enter = (-0.5 * edge - start) / way, leave = (0.5 * edge - start) / way;
        from = std::max(from, std::min(enter, leave));
        to = std::min(to, std::max(enter, leave));
    }
    return std::max(0.0, to - from) * distance(a, b);
}

std::size_t fingers_of(const HandRecording& recording) {
    std::size_t count = 0;
    for (const HandFrame& frame : recording.frames)
        for (const Hand& hand : frame.hands)
            for (const auto& finger : hand.fingers) count += finger ? 1 : 0;
    return count;
}

}  // namespace

TEST_CASE("hand: recorded hands touch a sphere and a cube as often as the sheet says", "[hand]") {
    if (!std::filesystem::exists(recordings())) {
        WARN("not tested: no recordings in " << recordings());
        return;
    }
    struct Expected {
        const char* name;
        std::size_t frames, fingers, sphere_fingers, sphere_frames, cube_fingers;
        double cube_mm;
    };
    const Expected e = GENERATE(Expected{"HandSplay-110fps", 288, 1440, 928, 288, 1163, 57'808.4},
                                Expected{"grab", 374, 1870, 486, 374, 951, 55'080.9},
                                Expected{"pinch", 307, 1535, 907, 307, 921, 69'280.5},
                                Expected{"flapping", 328, 3280, 428, 303, 678, 33'907.2});
    CAPTURE(e.name);
    const HandRecording recording = load_leap(recordings() / (std::string(e.name) + ".json.lz"));
    REQUIRE(recording.frames.size() == e.frames);
    REQUIRE(fingers_of(recording) == e.fingers);
    // About 115 frames a second; the tracker dropped some.
    const double interval_s = recording.frames.back().time_s / static_cast<double>(e.frames - 1);
    REQUIRE(interval_s == Approx(9.0e-3).margin(0.6e-3));
    const Vec3 centre = from_mm(0, 0, 200);
    const Solid sphere = solid_sphere(centre, 0.05), cube = solid_box(centre, {0.1, 0.1, 0.1});
    std::size_t sphere_fingers = 0, sphere_frames = 0, cube_fingers = 0;
    double cube_m = 0.0;
    for (const HandFrame& frame : recording.frames) {
        bool any = false;
        for (const Hand& hand : frame.hands) {
            CHECK(norm(hand.normal) == Approx(1.0).margin(1e-3));
            for (const auto& finger : hand.fingers) {
                bool in_sphere = false, in_cube = false;
                for (std::size_t i = 0; i < 3; ++i) {
                    const Vec3 a = finger->joints.at(i), b = finger->joints.at(i + 1);
                    in_sphere = in_sphere || least_along(sphere, a, b) < 0.0;
                    in_cube = in_cube || least_along(cube, a, b) < 0.0;
                    cube_m += length_in_box(a, b, centre, 0.1);
                }
                sphere_fingers += in_sphere ? 1 : 0;
                cube_fingers += in_cube ? 1 : 0;
                any = any || in_sphere;
            }
        }
        sphere_frames += any ? 1 : 0;
    }
    CHECK(sphere_fingers == e.sphere_fingers);
    CHECK(sphere_frames == e.sphere_frames);
    CHECK(cube_fingers == e.cube_fingers);
    CHECK(cube_m / millimetre == Approx(e.cube_mm).margin(0.05));
}

TEST_CASE("hand: the packed format has the same hand in other clothes", "[hand]") {
    if (!std::filesystem::exists(recordings())) {
        WARN("not tested: no recordings in " << recordings());
        return;
    }
    const HandRecording recording = load_leap(recordings() / "pinch-57fps.json.lz");
    REQUIRE(recording.frames.size() == 133);
    REQUIRE(fingers_of(recording) == 133 * 5);
    const Hand& hand = recording.frames.front().hands.at(0);
    CHECK(hand.right);
    CHECK(distance(hand.palm, from_mm(39.3046, -16.4911, 166.016)) < 1e-9);
    CHECK(distance(hand.fingers[1]->joints[0], from_mm(16.3391, -7.17147, 189.788)) < 1e-9);
    CHECK(recording.frames[1].time_s == Approx(17.437e-3));
    for (const HandFrame& frame : recording.frames)
        for (const auto& finger : frame.hands.at(0).fingers)
            for (std::size_t i = 0; i < 3; ++i) CHECK(distance(finger->joints.at(i), finger->joints.at(i + 1)) < 0.08);
}

TEST_CASE("hand: small recordings in both formats, and their mistakes", "[hand]") {
    const std::string finger =
        R"({"id": 71, "handId": 7, "type": 1, "tool": false, "width": 18, "mcpPosition": [0, 200, 0], "pipPosition": [0, 200, -40], "dipPosition": [0, 200, -65], "tipPosition": [0, 200, -85]})";
    const std::string hand =
        R"({"id": 7, "type": "left", "palmPosition": [1, 200, 30], "palmNormal": [0, -1, 0], "direction": [0, 0, -1], "palmVelocity": [10, 0, 0], "confidence": 0.5})";
    const auto recording = [](const std::string& hands, const std::string& fingers) {
        return R"({"frames": [{"timestamp": 1000000, "hands": [)" + hands + R"(], "pointables": [)" + fingers +
               R"(]}, {"timestamp": 1010000, "hands": [], "pointables": []}]})";
    };
    const HandRecording named = recording_from_leap(recording(hand, finger), "r.json");
    REQUIRE(named.frames.size() == 2);
    CHECK(named.frames[1].time_s == Approx(0.01));
    const Hand& one = named.frames[0].hands.at(0);
    CHECK_FALSE(one.right);
    CHECK(distance(one.palm, from_mm(1, -30, 200)) < 1e-12);
    CHECK(distance(one.normal, Vec3{0, 0, -1}) < 1e-12);
    CHECK(distance(one.direction, Vec3{0, 1, 0}) < 1e-12);
    CHECK(distance(one.velocity, Vec3{0.01, 0, 0}) < 1e-12);
    CHECK(one.confidence == 0.5);
    CHECK(distance(one.fingers[1]->joints[3], from_mm(0, 85, 200)) < 1e-12);
    CHECK(*one.fingers[1]->width_m == Approx(0.018));
    CHECK_FALSE(one.fingers[0].has_value());
    const HandRecording packed = recording_from_leap(
        R"({"frames": [["timestamp", {"hands": [["type", "id", "palmVelocity", "palmPosition", "palmNormal", "direction"]]}, {"pointables": [["handId", "id", "tipPosition", "dipPosition", "pipPosition", "mcpPosition"]]}], [5, [["left", 7, [10, 0, 0], [1, 200, 30], [0, -1, 0], [0, 0, -1]]], [[7, 71, [0, 200, -85], [0, 200, -65], [0, 200, -40], [0, 200, 0]]]]]})",
        "p.json");
    REQUIRE(packed.frames.size() == 1);
    CHECK(packed.frames[0].hands.at(0).palm == one.palm);
    CHECK(packed.frames[0].hands.at(0).fingers[1]->joints == one.fingers[1]->joints);
    const auto refuses = [](const std::string& text) {
        CAPTURE(text);
        REQUIRE_REFUSED(recording_from_leap(text, "r.json"));
    };
    refuses("{}");
    refuses(R"({"frames": []})");
    refuses(recording(hand, R"({"id": 81, "handId": 8})"));
    refuses(recording(R"({"id": 7, "type": "both"})", ""));
    refuses(recording(R"({"id": 7, "type": "left"})", ""));
    refuses("N4Ig!");
    refuses("");
    refuses(R"({"frames": [-1e999]})");
}

TEST_CASE("hand: LZString texts of other programs are read", "[hand]") {
    // A vector that the ports of lz-string share; its last character has 16 bits.
    CHECK(from_lz_string("BYUwNmD2A0AECWsCGBbZtDUzkAA=", "x") == "hello, i am a 猫");
    REQUIRE_REFUSED(from_lz_string("BYUw", "x"));
    REQUIRE_REFUSED(from_lz_string("////", "x"));
}

TEST_CASE("solid: signed distances are those of the nearest point of a dense surface", "[hand]") {
    struct Case {
        const char* name;
        Solid solid;
        std::function<bool(Vec3)> inside;
    };
    const Vec3 at{0.01, -0.02, 0.1};
    const auto local = [at](Vec3 p) { return p - at; };
    const std::vector<Case> cases{
        {"sphere", solid_sphere(at, 0.03), [=](Vec3 p) { return norm(local(p)) < 0.03; }},
        {"box", solid_box(at, {0.04, 0.06, 0.02}),
         [=](Vec3 p) {
             const Vec3 q = local(p);
             return std::abs(q.x) < 0.02 && std::abs(q.y) < 0.03 && std::abs(q.z) < 0.01;
         }},
        {"cylinder", solid_cylinder(at, 0.02, 0.05),
         [=](Vec3 p) {
             const Vec3 q = local(p);
             return std::hypot(q.x, q.y) < 0.02 && std::abs(q.z) < 0.025;
         }},
        {"cone", solid_cone(at, 0.03, 0.05),
         [=](Vec3 p) {
             const Vec3 q = local(p);
             return q.z > 0.0 && std::hypot(q.x, q.y) < 0.03 * (1.0 - q.z / 0.05);
         }},
        {"pyramid", solid_pyramid(at, 0.05, 0.04),
         [=](Vec3 p) {
             const Vec3 q = local(p);
             return q.z > 0.0 && std::max(std::abs(q.x), std::abs(q.y)) < 0.025 * (1.0 - q.z / 0.04);
         }},
        {"half-space", half_space(at, {0, 0, 2}), [=](Vec3 p) { return p.z < at.z; }},
        {"moved box", moved(solid_box({}, {0.02, 0.04, 0.06}), at, {0, 90, 0}),
         [=](Vec3 p) {
             const Vec3 q = local(p);  // a quarter turn about y brings the long edge to x
             return std::abs(q.x) < 0.03 && std::abs(q.y) < 0.02 && std::abs(q.z) < 0.01;
         }},
    };
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(-0.06, 0.06);
    for (const Case& c : cases) {
        CAPTURE(c.name);
        for (int i = 0; i < 300; ++i) {
            const Vec3 p = at + Vec3{place(random), place(random), place(random)};
            const double d = c.solid.distance(p);
            REQUIRE(c.solid.contains(p) == c.inside(p));
            // No surface is nearer: the sign holds in the whole ball.
            const double radius = std::abs(d);
            const auto direction = [&] {
                const Vec3 way{place(random), place(random), place(random)};
                return way * (1.0 / norm(way));
            };
            for (int k = 0; k < 400; ++k) REQUIRE(c.inside(p + 0.999 * radius * direction()) == c.inside(p));
            constexpr double h = 1e-7;
            const Vec3 slope{(c.solid.distance(p + Vec3{h, 0, 0}) - c.solid.distance(p - Vec3{h, 0, 0})) / (2 * h),
                             (c.solid.distance(p + Vec3{0, h, 0}) - c.solid.distance(p - Vec3{0, h, 0})) / (2 * h),
                             (c.solid.distance(p + Vec3{0, 0, h}) - c.solid.distance(p - Vec3{0, 0, h})) / (2 * h)};
            if (std::abs(norm(slope) - 1.0) > 1e-3) continue;  // on a ridge, where two ways are as near
            // Downhill by the distance itself lies the surface: around it there are points on either side.
            const Vec3 there = p - d * slope;
            bool reached = false;
            for (int k = 0; k < 2000 && !reached; ++k) reached = c.inside(there + 2e-5 * direction()) != c.inside(p);
            REQUIRE(reached);
        }
    }
    REQUIRE_REFUSED(solid_sphere({}, 0.0));
    REQUIRE_REFUSED(solid_box({}, {1, -1, 1}));
    REQUIRE_REFUSED(half_space({}, {}));
}

TEST_CASE("skin: six regions of cells of a millimetre, facing out of the palm", "[hand]") {
    const Hand hand = synthetic_hand(GENERATE(HandScript::press, HandScript::grasp, HandScript::wave), 0.4);
    const std::vector<SkinRegion> regions = palmar_surface(hand);
    REQUIRE(regions.size() == 6);
    REQUIRE(regions.back().name == "palm");
    for (std::size_t i = 0; i < regions.size(); ++i) {
        const SkinRegion& r = regions[i];
        CAPTURE(r.name);
        REQUIRE(r.points.size() == r.rows * r.columns);
        REQUIRE(r.normals.size() == r.points.size());
        for (std::size_t row = 0; row < r.rows; ++row) {
            for (std::size_t column = 0; column < r.columns; ++column) {
                const Vec3 normal = r.normals[row * r.columns + column];
                REQUIRE(norm(normal) == Approx(1.0));
                // Over the round end of the tip the skin goes on to the nail.
                const SkinPatch& last = r.patches.back();
                const double beyond = dot(r.point(row, column) - last.from, last.along) - last.length;
                if (!last.tip || beyond < 1e-9) REQUIRE((dot(normal, hand.normal) >= -1e-9 || beyond > -1e-9));
                if (column > 0) REQUIRE(distance(r.point(row, column), r.point(row, column - 1)) <= 1e-3 + 1e-12);
            }
        }
        if (i == 5) continue;
        // Every point is at one of the three radii from its finger's chain.
        const Finger& finger = *hand.fingers.at(i);
        const double thumb = i == 0 ? 1e-3 : 0.0;
        for (const Vec3& p : r.points) {
            double off = 1.0;
            for (std::size_t s = 0; s < 3; ++s) {
                const Vec3 a = finger.joints.at(s), b = finger.joints.at(s + 1);
                const double part = std::clamp(dot(p - a, b - a) / dot(b - a, b - a), 0.0, 1.0);
                const double radius = 9.5e-3 - static_cast<double>(s) * 1e-3 + thumb;
                off = std::min(off, std::abs(distance(p, a + part * (b - a)) - radius));
            }
            REQUIRE(off < 1e-9);
        }
    }
    const SkinRegion& palm = regions.back();
    CHECK(distance(palm.points.front(), palm.points.back()) == Approx(std::hypot(0.085, 0.090)));
    Hand wide = hand;
    for (auto& finger : wide.fingers) finger->width_m = 0.02;
    const std::vector<SkinRegion> wider = palmar_surface(wide);
    CHECK(wider[1].columns > regions[1].columns);
    CHECK(distance(wider[1].point(0, 0), wider[1].point(0, wider[1].columns - 1)) == Approx(0.02 * 9.5 / 8.5));
    SkinOptions wrong;
    wrong.cell_m = 0.0;
    REQUIRE_REFUSED(palmar_surface(hand, wrong));
}

TEST_CASE("hand: synthetic hands move as their velocity says, and keep their bones", "[hand]") {
    const std::string name = GENERATE("press", "slide", "grasp", "wave");
    const HandScript script = hand_script(name);
    constexpr double h = 1e-6;
    const Hand begin = synthetic_hand(script, 0.0);
    double farthest = 0.0;
    for (int i = 0; i < 60; ++i) {
        const double t = 0.05 * i;
        const Hand hand = synthetic_hand(script, t);
        const Vec3 rate = (synthetic_hand(script, t + h).palm - synthetic_hand(script, t - h).palm) * (0.5 / h);
        REQUIRE(distance(rate, hand.velocity) < 1e-5);
        REQUIRE(norm(hand.direction) == Approx(1.0));
        farthest = std::max(farthest, distance(hand.palm, begin.palm));
        for (std::size_t f = 0; f < 5; ++f)
            for (std::size_t s = 0; s < 3; ++s)
                REQUIRE(distance(hand.fingers.at(f)->joints.at(s), hand.fingers.at(f)->joints.at(s + 1)) ==
                        Approx(distance(begin.fingers.at(f)->joints.at(s), begin.fingers.at(f)->joints.at(s + 1))));
    }
    const double expected = name == "press"   ? 0.03
                            : name == "slide" ? 0.06
                            : name == "grasp" ? 0.0
                                              : 2 * 0.05 * std::sin(pi / 12);
    CHECK(farthest == Approx(expected).margin(3e-4));
    if (name == "grasp")  // the index finger's tip comes down
        CHECK(synthetic_hand(script, 1.0).fingers[1]->joints[3].z < begin.fingers[1]->joints[3].z - 0.03);
    REQUIRE_REFUSED(hand_script("clap"));
}
