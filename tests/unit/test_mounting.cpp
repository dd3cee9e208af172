// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/hand/mounting.hpp"
#include "haptogram/verbs/hand_source.hpp"

using namespace haptogram;

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
    /// Of known places. @param sd  of what the tracker says, metres in each direction
    std::vector<SeenPoint> touches(const Pose& pose, const std::vector<Vec3>& places, double sd) {
        std::vector<SeenPoint> points;
        for (const Vec3 known : places) points.push_back({known, pose.inwards(known) + noise(sd)});
        return points;
    }
    /// Of places anywhere within reach of a tile.
    std::vector<SeenPoint> touches(const Pose& pose, std::size_t count, double sd) {
        std::vector<Vec3> places;
        for (std::size_t i = 0; i < count; ++i) places.push_back(in_box({0.06, 0.06, 0.05}, {0, 0, 0.12}));
        return touches(pose, places, sd);
    }
};

/// Places within 60° of the axis of a tile, up to 320 mm above it.
std::vector<Vec3> in_reach() {
    std::vector<Vec3> places;
    for (int x = -5; x <= 5; ++x)
        for (int y = -5; y <= 5; ++y)
            for (int z = 0; z <= 10; ++z) {
                const Vec3 place{0.03 * x, 0.03 * y, 0.02 + 0.03 * z};
                if (std::hypot(place.x, place.y) <= std::sqrt(3.0) * place.z) places.push_back(place);
            }
    return places;
}

double degrees_between(const Pose& a, const Pose& b) {
    const double trace = dot(a.x, b.x) + dot(a.y, b.y) + dot(a.z, b.z);
    return std::acos(std::clamp(0.5 * (trace - 1.0), -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

}  // namespace

TEST_CASE("ten touches find a tracker's mounting, where they are asked for within half a degree", "[mounting]") {
    Bench bench;
    const bool asked = GENERATE(false, true);
    constexpr int tries = 500;
    constexpr std::size_t count = 10;
    std::vector<Vec3> where;
    const std::vector<Vec3> places = in_reach();
    while (asked && where.size() < count) where.push_back(next_touch(where, places));
    std::vector<double> off_m, off_deg;
    int within_m = 0, within_rad = 0;
    for (int i = 0; i < tries; ++i) {
        const Pose truth = bench.pose();
        // 1 mm of noise as the length of the error; a direction has its third part of the variance.
        const double sd_m = 1e-3 / std::sqrt(3.0);
        const std::vector<SeenPoint> touches =
            asked ? bench.touches(truth, where, sd_m) : bench.touches(truth, count, sd_m);
        const Alignment found = align(touches, "touches");
        std::vector<Vec3> known;
        Vec3 middle;
        for (const SeenPoint& point : touches) {
            known.push_back(point.known);
            middle = middle + (1.0 / static_cast<double>(count)) * point.known;
        }
        off_m.push_back(norm(found.pose.outwards(truth.inwards(middle)) - middle));
        off_deg.push_back(degrees_between(found.pose, truth));
        REQUIRE(found.noise_m);
        const Sureness said = sureness_of(known, *found.noise_m, true);
        within_m += off_m.back() <= said.place_m ? 1 : 0;
        within_rad += off_deg.back() * std::numbers::pi / 180.0 <= said.angle_rad ? 1 : 0;
    }
    std::ranges::sort(off_m);
    std::ranges::sort(off_deg);
    fmt::print(
        "10 touches {} with 1 mm of noise, {} mountings: {:.2f} mm and {:.2f} degrees in the median, {:.2f} and {:.2f} "
        "in the worst; {} and {} within what it says\n",
        asked ? "as asked" : "anywhere", tries, 1e3 * off_m[tries / 2], off_deg[tries / 2], 1e3 * off_m.back(),
        off_deg.back(), within_m, within_rad);
    CHECK(off_m.back() <= 1e-3);
    CHECK((asked ? off_deg.back() : off_deg[tries / 2]) <= 0.5);
    // It says within what 95 of 100 are: 475 of 500, and five standard deviations of that number at most.
    CHECK(std::abs(within_m - 475) < 25);
    CHECK(std::abs(within_rad - 475) < 25);
}

TEST_CASE("few touches say of themselves that they are few", "[mounting]") {
    Bench bench;
    for (const std::size_t count : {4U, 5U, 6U}) {
        int within = 0;
        constexpr int tries = 500;
        for (int i = 0; i < tries; ++i) {
            const Pose truth = bench.pose();
            const std::vector<SeenPoint> touches = bench.touches(truth, count, 5e-4);
            std::vector<Vec3> known;
            for (const SeenPoint& point : touches) known.push_back(point.known);
            const Alignment found = align(touches, "touches");
            const double off = degrees_between(found.pose, truth) * std::numbers::pi / 180.0;
            within += off <= sureness_of(known, *found.noise_m, true).angle_rad ? 1 : 0;
        }
        INFO(count << " touches: " << within << " of " << tries);
        CHECK(within > 450);
        CHECK(within < 496);
    }
    // Exactly: where the noise is known, a length of three equal errors is below 2.795 of theirs.
    const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    CHECK(sureness_of(corners, 1.0, false).place_m == Approx(2.795 / 2.0).epsilon(0.01));
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
    CHECK_REFUSED(align(points, "p.txt"));
    points.push_back({0.5 * (points[0].known + points[1].known), 0.5 * (points[0].seen + points[1].seen)});
    CHECK_REFUSED(align(points, "p.txt"));
}

TEST_CASE("a mounting is written and read again", "[mounting]") {
    Bench bench;
    const Pose truth = bench.pose();
    const Pose read = mounting_from_toml(mounting_to_toml(truth, {"By hand."}), "desk.toml");
    CHECK(norm(read.origin - truth.origin) < 1e-15);
    CHECK(degrees_between(read, truth) < 1e-5);
    const auto refused = [](const char* text) {
        return heard::refusal_of([&] { (void)mounting_from_toml(text, "desk.toml"); });
    };
    CHECK_REFUSAL(refused("position_mm = [0, 0, 0]\nright = [1, 0, 0]\nforward = [1, 0, 0]\n"));
    CHECK_REFUSAL(refused("position_mm = [0, 0]\nright = [1, 0, 0]\nforward = [0, 0, 1]\n"));
    CHECK_REFUSAL(refused("right = [1, 0, 0]\nforward = [0, 0, 1]\n"));
    CHECK_REFUSAL(refused("position_mm = [0, 0, 0]\nright = [1, 0, 0]\nforward = [0, 0, 1]\nup = 3\n"));
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
