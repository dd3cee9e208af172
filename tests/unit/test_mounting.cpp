// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/mounting.hpp"
#include "message_of.hpp"

using namespace haptogram;
using Catch::Contains;

namespace {

struct Bench {
    std::mt19937 random{7};

    double between(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
    Vec3 in_box(Vec3 half, Vec3 middle) {
        return middle + Vec3{between(-half.x, half.x), between(-half.y, half.y), between(-half.z, half.z)};
    }
    Vec3 noise(double sd) {
        std::normal_distribution<double> one(0.0, sd);
        return {one(random), one(random), one(random)};
    }
    Pose pose() {
        return pose_of(in_box({0.3, 0.3, 0.3}, {}), {between(-180, 180), between(-180, 180), between(-180, 180)});
    }
    /// Touches within reach of a tile. @param sd  of what the tracker says, metres in each direction
    /// @param corners  of the box alone, one after the other, and not anywhere in it
    std::vector<SeenPoint> touches(const Pose& pose, std::size_t count, double sd, bool corners = false) {
        constexpr Vec3 half{0.06, 0.06, 0.05}, middle{0, 0, 0.12};
        std::vector<SeenPoint> points;
        for (std::size_t i = 0; i < count; ++i) {
            const auto side = [i](unsigned bit, double most) { return (i >> bit & 1U) != 0 ? most : -most; };
            const Vec3 known =
                corners ? middle + Vec3{side(0, half.x), side(1, half.y), side(2, half.z)} : in_box(half, middle);
            points.push_back({known, pose.inwards(known) + noise(sd)});
        }
        return points;
    }
};

double degrees_between(const Pose& a, const Pose& b) {
    const double trace = dot(a.x, b.x) + dot(a.y, b.y) + dot(a.z, b.z);
    return std::acos(std::clamp(0.5 * (trace - 1.0), -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

}  // namespace

TEST_CASE("ten touches find a tracker's mounting, at corners within half a degree", "[mounting]") {
    Bench bench;
    const bool corners = GENERATE(false, true);
    constexpr int tries = 500;
    const Vec3 middle{0, 0, 0.12};
    std::vector<double> off_m, off_deg;
    double squared_m = 0.0, said_m = 0.0, squared_rad = 0.0, said_rad = 0.0;
    for (int i = 0; i < tries; ++i) {
        const Pose truth = bench.pose();
        // 1 mm of noise as the length of the error; a direction has its third part of the variance.
        const Alignment found = align(bench.touches(truth, 10, 1e-3 / std::sqrt(3.0), corners), "touches");
        off_m.push_back(norm(found.pose.outwards(truth.inwards(middle)) - middle));
        off_deg.push_back(degrees_between(found.pose, truth));
        squared_m += off_m.back() * off_m.back() / tries;
        squared_rad += std::pow(off_deg.back() * std::numbers::pi / 180.0, 2) / tries;
        said_m += found.position_m * found.position_m / tries;
        said_rad += found.angle_rad * found.angle_rad / tries;
    }
    std::ranges::sort(off_m);
    std::ranges::sort(off_deg);
    fmt::print(
        "10 touches {} with 1 mm of noise, {} mountings: {:.2f} mm and {:.2f} degrees in the median, {:.2f} and {:.2f} "
        "in the worst\n",
        corners ? "at corners" : "anywhere", tries, 1e3 * off_m[tries / 2], off_deg[tries / 2], 1e3 * off_m.back(),
        off_deg.back());
    CHECK(off_m[tries * 95 / 100] <= 1e-3);
    CHECK(off_deg[corners ? tries * 95 / 100 : tries / 2] <= 0.5);
    // What it says of its errors is so: three directions of the place, and the worst axis of three.
    CHECK(std::sqrt(squared_m) == Approx(std::sqrt(3.0 * said_m)).epsilon(0.35));
    CHECK(std::sqrt(squared_rad) > 0.8 * std::sqrt(said_rad));
    CHECK(std::sqrt(squared_rad) < 1.8 * std::sqrt(said_rad));
}

TEST_CASE("exact points give the exact mounting, also in a plane", "[mounting]") {
    Bench bench;
    for (int i = 0; i < 50; ++i) {
        const Pose truth = bench.pose();
        std::vector<SeenPoint> points = bench.touches(truth, 4, 0.0);
        for (SeenPoint& point : points)
            point = {{point.known.x, point.known.y, 0.0}, truth.inwards({point.known.x, point.known.y, 0.0})};
        const Alignment found = align(points, "touches");
        CHECK(norm(found.pose.origin - truth.origin) < 1e-12);
        CHECK(degrees_between(found.pose, truth) < 1e-5);
        CHECK(norm(cross(found.pose.x, found.pose.y) - found.pose.z) < 1e-12);  // no mirror image
    }
}

TEST_CASE("a touch of the wrong point stands out", "[mounting]") {
    Bench bench;
    for (int i = 0; i < 50; ++i) {
        std::vector<SeenPoint> points = bench.touches(bench.pose(), 8, 3e-4);
        const auto wrong = static_cast<std::size_t>(i) % points.size();
        points[wrong].seen = points[wrong].seen + Vec3{0.02, 0, 0};
        const std::vector<double> off = align(points, "touches").residuals_without_m;
        CHECK(static_cast<std::size_t>(std::ranges::max_element(off) - off.begin()) == wrong);
    }
}

TEST_CASE("points that leave a turn open are refused", "[mounting]") {
    Bench bench;
    const Pose truth = bench.pose();
    std::vector<SeenPoint> points = bench.touches(truth, 2, 0.0);
    CHECK_THAT(message_of([&] { (void)align(points, "p.txt"); }),
               Contains("p.txt: found 2 points, expected at least 3"));
    points.push_back({0.5 * (points[0].known + points[1].known), 0.5 * (points[0].seen + points[1].seen)});
    CHECK_THAT(message_of([&] { (void)align(points, "p.txt"); }), Contains("lie on a line"));
}

TEST_CASE("a mounting is written and read again", "[mounting]") {
    Bench bench;
    const Pose truth = bench.pose();
    const Pose read = mounting_from_toml(mounting_to_toml(truth, {"By hand."}), "desk.toml");
    CHECK(norm(read.origin - truth.origin) < 1e-15);
    CHECK(degrees_between(read, truth) < 1e-5);
    const auto refused = [](const char* text) {
        return message_of([&] { (void)mounting_from_toml(text, "desk.toml"); });
    };
    CHECK_THAT(refused("position_mm = [0, 0, 0]\nright = [1, 0, 0]\nforward = [1, 0, 0]\n"),
               Contains("desk.toml:2") && Contains("right angles"));
    CHECK_THAT(refused("position_mm = [0, 0]\nright = [1, 0, 0]\nforward = [0, 0, 1]\n"), Contains("desk.toml:1"));
    CHECK_THAT(refused("right = [1, 0, 0]\nforward = [0, 0, 1]\n"), Contains("position_mm is missing"));
    CHECK_THAT(refused("position_mm = [0, 0, 0]\nright = [1, 0, 0]\nforward = [0, 0, 1]\nup = 3\n"), Contains("up"));
    CHECK(without_mounting("a@b.toml") == std::pair<std::string, std::string>("a", "b.toml"));
    CHECK(without_mounting("a@b.json") == std::pair<std::string, std::string>("a@b.json", ""));
}

TEST_CASE("touches are where a fingertip stays", "[mounting]") {
    Bench bench;
    const std::vector<Vec3> places = {{0, 0, 0.1}, {0.05, 0, 0.1}, {0.05, 0.05, 0.1}, {0, 0, 0.15}};
    HandRecording recording;
    double time_s = 0.0;
    const auto add = [&](Vec3 tip) {
        Hand hand;
        hand.fingers[1] = Finger{{tip, tip, tip, tip}, {}};
        recording.frames.push_back({time_s, {hand}});
        time_s += 0.01;
    };
    Vec3 from = places.front();
    for (const Vec3 place : places) {
        for (int i = 0; i < 50; ++i) add(from + (i / 50.0) * (place - from));
        for (int i = 0; i < 100; ++i) add(place + bench.noise(3e-4));
        recording.frames.push_back({time_s, {}});  // the hand is lost for a frame
        from = place;
    }
    const std::vector<Vec3> touches = touches_in(recording);
    REQUIRE(touches.size() == places.size());
    for (std::size_t i = 0; i < places.size(); ++i) CHECK(norm(touches[i] - places[i]) < 1e-3);
    CHECK(touches_in(recording, 2).empty());
    CHECK(touches_in(recording, 1, 10.0).empty());
}
