// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <ctime>
#include <numbers>
#include <random>
#include <tuple>

#include "../refusal.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/live/cluster.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/depth_source.hpp"
#include "haptogram/live/touch_scene.hpp"
#include "recorded_depth.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;

std::vector<Vec3> recorded_points(CloudMaker& maker, const DepthCamera& camera, const char* name) {
    return maker.points(camera, depth_from_png(read_file(recorded_depth() / name), name, camera));
}

/// A finger pad: points on a ball that are evenly spread, some 0.7 mm apart.
std::vector<Vec3> pad(Vec3 middle, double radius = 8e-3) {
    std::vector<Vec3> points;
    const int count = 1600;
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z),
                     turn = i * pi * (3.0 - std::sqrt(5.0));
        points.push_back(middle + radius * Vec3{r * std::cos(turn), r * std::sin(turn), z});
    }
    return points;
}

std::vector<Vec3> both(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    std::vector<Vec3> all = a;
    all.insert(all.end(), b.begin(), b.end());
    return all;
}

}  // namespace

TEST_CASE("scene: clusters of a recorded hand in a half-space (F3)") {
    if (recorded_depth().empty()) {
        WARN("skipped: there are no recorded depth frames in ../shared/data/depth");
        return;
    }
    const DepthCamera camera;
    CloudOptions options;
    options.low = {-1, -1, 0.001};
    options.high = {1, 1, std::nextafter(0.6, 0.0)};
    options.window_px = 1;
    CloudMaker maker(options);
    const std::vector<Vec3> cloud = recorded_points(maker, camera, "130.png");
    const auto beyond = [&](double x) {
        std::vector<Vec3> inside;
        for (const Vec3& p : cloud)
            if (p.x > x) inside.push_back(p);
        return clusters_of(inside, 3e-3, 30);
    };
    const std::vector<Cluster> four = beyond(20e-3);
    REQUIRE(four.size() == 4);
    const std::size_t sizes[] = {571, 528, 174, 114};
    const Vec3 centroids[] = {from_mm(36.8, 3.5, 477.9), from_mm(36.6, -22.6, 481.1), from_mm(25.7, -51.9, 478.3),
                              from_mm(24.2, 44.0, 490.4)};
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(four[i].points.size() == sizes[i]);
        CHECK(std::abs(four[i].centroid.x - centroids[i].x) < 0.051e-3);
        CHECK(std::abs(four[i].centroid.y - centroids[i].y) < 0.051e-3);
        CHECK(std::abs(four[i].centroid.z - centroids[i].z) < 0.051e-3);
    }
    const std::vector<Cluster> two = beyond(40e-3);
    REQUIRE(two.size() == 2);
    CHECK(two[0].points.size() == 221);
    CHECK(two[1].points.size() == 204);
}

TEST_CASE("scene: sections of recorded fingers need the guard, and with it are of a finger's size (F4)") {
    if (recorded_depth().empty()) {
        WARN("skipped: there are no recorded depth frames in ../shared/data/depth");
        return;
    }
    DepthCamera camera;
    CloudOptions cut;
    cut.low = {-1, -1, 0.001};
    cut.high = {1, 1, 0.6};
    CloudMaker maker(cut);
    SceneOptions options;
    options.kind = "half-space";
    options.mass_kg = 0.0;
    options.pose = {.origin = {20e-3, 0, 0}, .x = {0, 1, 0}, .y = {0, 0, -1}, .z = {-1, 0, 0}};
    // In the third frame the hand points another way, and the face cuts its palm and thumb, which are no fingers.
    for (const auto& [name, least, most] : {std::tuple("110.png", 2, 9), {"130.png", 2, 9}, {"150.png", 0, 0}}) {
        INFO(name);
        TouchScene scene(options);
        const auto& fingers = scene.update(recorded_points(maker, camera, name), 0.0);
        REQUIRE(fingers.size() >= 2);
        int found = 0;
        for (const SceneFinger& finger : fingers) {
            const auto section = section_of(finger.section, finger.surface, finger.inward, finger.place);
            if (!section) continue;
            ++found;
            CHECK(section->constrained);
            CHECK(section->ellipse.half_major > 3e-3);
            CHECK(section->ellipse.half_major < 15e-3);
        }
        CHECK(found >= least);
        CHECK(found <= most);
    }
}

TEST_CASE("scene: clusters are the connected components that every pair of points tells") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(0.0, 0.03);
    std::vector<Vec3> points(400);
    for (Vec3& p : points) p = {place(random), place(random), place(random)};
    const double joined = 2.2e-3;
    std::vector<std::size_t> label(points.size());
    for (std::size_t i = 0; i < label.size(); ++i) label[i] = i;
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t j = 0; j < points.size(); ++j)
                if (distance(points[i], points[j]) <= joined && label[j] < label[i]) {
                    label[i] = label[j];
                    changed = true;
                }
    }
    std::vector<std::size_t> sizes;
    for (std::size_t i = 0; i < label.size(); ++i)
        if (const auto count = std::count(label.begin(), label.end(), i); count > 0)
            sizes.push_back(static_cast<std::size_t>(count));
    std::sort(sizes.rbegin(), sizes.rend());
    const std::vector<Cluster> clusters = clusters_of(points, joined, 1);
    REQUIRE(clusters.size() == sizes.size());
    for (std::size_t i = 0; i < sizes.size(); ++i) CHECK(clusters[i].points.size() == sizes[i]);
    CHECK_REFUSED(clusters_of(points, 0.0, 1));
}

TEST_CASE("scene: fingers keep their identity over shots, over one lost shot, and lose it after two") {
    const auto at = [](std::initializer_list<Vec3> places) {
        std::vector<Cluster> clusters;
        for (const Vec3 p : places) clusters.push_back({{p}, p});
        return clusters;
    };
    FingerTracker tracker;
    auto now = tracker.update(at({{0, 0, 0}, {0.03, 0, 0}}));
    REQUIRE(now.size() == 2);
    const auto first = now[0].id, second = now[1].id;
    now = tracker.update(at({{0.035, 0, 0}, {0.01, 0, 0}}));  // in the other order, and moved
    CHECK(now[0].id == first);
    CHECK(now[0].cluster == 1);
    CHECK(now[1].id == second);
    now = tracker.update(at({{0.036, 0, 0}}));
    REQUIRE(now.size() == 2);
    CHECK_FALSE(now[0].seen);
    CHECK(now[0].place == Vec3{0.01, 0, 0});
    now = tracker.update(at({{0.012, 0, 0}, {0.036, 0, 0}}));
    CHECK(now[0].id == first);
    (void)tracker.update({});
    CHECK(tracker.update({}).empty());
    now = tracker.update(at({{0.012, 0, 0}}));
    CHECK(now.at(0).id != first);
    now = tracker.update(at({{0.04, 0, 0}}));  // farther than the gate: another finger
    CHECK(now.size() == 2);
}

TEST_CASE("scene: a god-object slides until dynamic friction is left (F7)") {
    const Vec3 x{3, 0, 2}, n{0, 0, 1};
    const Vec3 slid_to = slid({}, x, n, 0.6, 0.4);
    CHECK(distance(slid_to, {2.2, 0, 0}) < 1e-12);
    CHECK(dot(x - slid_to, {1, 0, 0}) == Approx(0.4 * dot(x - slid_to, n)));
    CHECK(slid({}, {1.2, 0, 2}, n, 0.6, 0.4) == Vec3{});  // held
    CHECK(slid({}, {3, 0, -2}, n, 0.6, 0.4) == Vec3{});   // outside
    ContactOptions options;
    options.dynamic_friction = 0.9;
    CHECK_REFUSED(require_sound(options));
}

TEST_CASE("scene: the section of a pad grows with its depth as a ball's does (F12)") {
    SceneOptions options;
    options.kind = "half-space";
    options.mass_kg = 0.0;
    options.pose.origin = {0, 0, 0.2};
    options.slab_m = 0.4e-3;
    options.least_points = 5;
    TouchScene scene(options);
    const std::pair<double, double> rows[] = {{0.5, 2.784}, {1, 3.873}, {2, 5.292}, {3, 6.245}, {4, 6.928}, {6, 7.746}};
    double time = 0.0;
    for (const auto& [depth, radius] : rows) {
        std::vector<Vec3> dense;
        for (double turn = 0.0; turn < 0.02; turn += 0.004)  // several turned copies, for a denser pad
            for (const Vec3& p : pad({0, 0, 0}))
                dense.push_back(Vec3{p.x * std::cos(turn) - p.y * std::sin(turn),
                                     p.x * std::sin(turn) + p.y * std::cos(turn), p.z} +
                                Vec3{0.01, 0, 0.2 + 8e-3 - depth * 1e-3});
        const auto& fingers = scene.update(dense, time += 1.0 / 30.0);
        INFO(depth);
        REQUIRE(fingers.size() == 1);
        CHECK(fingers[0].deepest_m == Approx(depth * 1e-3).margin(0.02e-3));
        if (depth < 1.0) continue;  // below the least size of a section that is trusted
        const auto section = section_of(fingers[0].section, fingers[0].surface, fingers[0].inward);
        REQUIRE(section.has_value());
        CHECK(1e3 * section->ellipse.half_major == Approx(radius).epsilon(0.04));
        CHECK(distance(section->ellipse.centre, {0.01, 0, 0.2}) < 0.1e-3);
    }
}

TEST_CASE("scene: four cameras give a finger's section to half a millimetre, and its half axes to 5 %") {
    // A round finger of 8 mm that enters a face obliquely: its section is an ellipse of 8 mm by 8 mm / 0.8125.
    const double radius = 8e-3, tilt = std::acos(0.8125);
    DepthNoise noise;
    noise.seed = Catch::rngSeed();
    INFO("seed " << noise.seed);
    std::mt19937_64 random(noise.seed);
    std::uniform_real_distribution<double> shift(-5e-3, 5e-3);
    for (int round = 0; round < 3; ++round) {
        const Vec3 where{shift(random), shift(random), 0.2};
        const double turn = 2.0 * pi * shift(random) / 10e-3;
        const Vec3 along{std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)};
        const std::vector<RoundedBody> finger{{where + 0.005 * along, 0.03 * along, {}, radius}};
        const std::vector<DepthCamera> cameras = cameras_around(where, 0.3, 4);
        DepthShot shot;
        for (std::size_t i = 0; i < 4; ++i)
            shot.pictures.emplace_back(
                render_depth(finger, cameras[i], noise, static_cast<std::uint64_t>(round) * 4 + i));
        CloudMaker maker({});
        SceneOptions options;
        options.size_m = 60e-3;
        options.pose.origin = where - Vec3{0, 0, 30e-3};
        options.mass_kg = 0.0;
        TouchScene scene(options);
        const auto& fingers = scene.update(maker.cloud(cameras, shot), 0.0);
        REQUIRE(fingers.size() == 1);
        // The finger came from above; the middle of its part inside may lie nearer to another face of a small cube.
        const auto section = section_of(fingers[0].section, where, {0, 0, -1});
        REQUIRE(section.has_value());
        INFO(fingers[0].section.size() << " points, " << 1e3 * section->ellipse.half_major << " x "
                                       << 1e3 * section->ellipse.half_minor << " mm, off by "
                                       << 1e3 * distance(section->ellipse.centre, where));
        CHECK_FALSE(section->constrained);
        CHECK(distance(section->ellipse.centre, where) < 0.5e-3);
        CHECK(section->ellipse.half_minor == Approx(radius).epsilon(0.05));
        CHECK(section->ellipse.half_major == Approx(radius / 0.8125).epsilon(0.05));
    }
}

TEST_CASE("scene: a cube that falls, turns and rests never gains energy") {
    WorldOptions options;
    World world(options);
    Pose pose = pose_of({0.01, 0.02, 0.25}, {20, 30, 10});
    world.add("cube", 40e-3, 40e-3, {0.1, pose});
    double energy = world.energy(0);
    CHECK(energy == Approx(0.1 * 9.80665 * 0.15).epsilon(1e-5));
    const double fallen_s = 0.05;
    for (double time = 0.0; time < fallen_s - 1e-9; time += options.step_s) world.step();
    CHECK(0.25 - world.pose(0).origin.z == Approx(0.5 * 9.80665 * fallen_s * fallen_s).epsilon(0.03));  // steps of 1 ms
    energy = world.energy(0);
    for (int step = 0; step < 600; ++step) {
        world.step();
        const double now = world.energy(0);
        // Bullet counts in single precision, and lifts what has got into the floor out of it: by 0.2 mm here.
        REQUIRE(now < energy + 2e-4);
        energy = std::min(energy, now);
    }
    CHECK(world.pose(0).origin.z == Approx(0.12).margin(0.5e-3));
    CHECK(energy == Approx(0.1 * 9.80665 * 0.02).epsilon(0.03));
}

TEST_CASE("scene: two fingers lift a cube, one does not, and held still it gains no energy") {
    SceneOptions options;
    options.pose.origin = {0, 0, 0.12};
    const auto run = [&](double squeeze_m, bool second, double friction) {
        SceneOptions with = options;
        with.contact.static_friction = friction;
        with.contact.dynamic_friction = 0.75 * friction;
        TouchScene scene(with);
        double time = 0.0, largest = 0.0, energy = 0.0;
        const auto fingers = [&](double gap, double height) {
            const double away = 20e-3 + 8e-3 + gap;
            const auto left = pad({-away, 0, height}), right = pad({away, 0, height});
            (void)scene.update(second ? both(left, right) : left, time += 1.0 / 30.0);
        };
        for (int i = 0; i <= 30; ++i) fingers(2e-3 - (squeeze_m + 2e-3) * i / 30.0, 0.12);
        for (int i = 0; i <= 30; ++i) fingers(-squeeze_m, 0.12 + 0.06 * i / 30.0);
        for (int i = 0; i < 45; ++i) {
            fingers(-squeeze_m, 0.18);
            if (i == 15) energy = scene.energy();
            if (i > 15) {
                largest = std::max(largest, scene.energy() - energy);
                energy = std::min(energy, scene.energy());
            }
        }
        return std::pair(scene.object().origin.z - 0.12, largest);
    };
    const auto [lifted, gained] = run(12e-3, true, 0.8);
    CHECK(lifted > 0.045);
    CHECK(gained < 2e-5);
    CHECK(run(12e-3, false, 0.8).first < 0.01);
    CHECK(run(12e-3, true, 0.1).first < 0.01);
}

TEST_CASE("scene: a cube that is held beside its middle swings and gains no energy") {
    SceneOptions options;
    options.pose.origin = {0, 0, 0.12};
    options.contact.spread_m = 6e-3;  // so that it does not slide out of the fingers
    TouchScene scene(options);
    double time = 0.0, lowest = HUGE_VAL, made = 0.0, most_turned = 0.0;
    const auto fingers = [&](double gap, double height) {
        const double away = 20e-3 + 8e-3 + gap;
        (void)scene.update(both(pad({-away, 6e-3, height}), pad({away, 6e-3, height})), time += 1.0 / 30.0);
        const double balance = scene.energy() - scene.work();
        lowest = std::min(lowest, balance);
        made = std::max(made, balance - lowest);
        most_turned = std::max(most_turned, std::abs(scene.object().y.z));
    };
    for (int i = 0; i <= 30; ++i) fingers(2e-3 - 14e-3 * i / 30.0, 0.12);
    for (int i = 0; i <= 20; ++i) fingers(-12e-3, 0.12 + 0.06 * i / 20.0);
    for (int i = 0; i < 150; ++i) fingers(-12e-3, 0.18);
    CHECK(scene.object().origin.z > 0.16);
    CHECK(most_turned > 0.1);
    INFO(1e3 * made << " mJ");
    CHECK(made < 2e-5);
}

TEST_CASE("scene: what it is given and cannot use is named") {
    SceneOptions options;
    options.kind = "cone";
    CHECK_REFUSAL(heard::refusal_of([&] { TouchScene scene(options); }));
    options = {};
    TouchScene scene(options);
    (void)scene.update({}, 1.0);
    CHECK_REFUSED(scene.update({}, 1.0));
    options.contact.stiffness_n_m = -1.0;
    CHECK_REFUSAL(heard::refusal_of([&] { TouchScene other(options); }));
}
