// SPDX-License-Identifier: Apache-2.0
// Measures the way from depth pictures to rings for tools/bench.py, on one thread; prints one JSON object. Times are
// the least of several runs, as other programs only add to them.
#include <fmt/core.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/shot_rings.hpp"
#include "haptogram/live/source.hpp"
#include "least.hpp"

namespace {

using namespace haptogram;

/// A whole hand, seen by the cameras, of which a fingertip presses on a cube.
struct Scene {
    std::vector<RoundedBody> bodies;
    live::FingerOptions options;
};

Scene hand_on_a_cube() {
    const Hand hand = synthetic_hand(HandScript::press, 0.0, 0.2);
    Scene scene;
    scene.bodies = bodies_of(hand);
    const Vec3 index = hand.fingers[1]->joints[3], middle = hand.fingers[2]->joints[3];
    scene.options.scene.size_m = 60e-3;
    scene.options.scene.mass_kg = 0.0;
    // The fingertips are 3 mm deep in the cube's face, which looks at them.
    scene.options.scene.pose.origin = 0.5 * (index + middle) + Vec3{0, 7.5e-3 - 3e-3 + 30e-3, 0};
    return scene;
}

nlohmann::ordered_json measured(const std::vector<DepthCamera>& cameras, const Scene& scene) {
    constexpr std::uint64_t shots = 40;
    std::vector<DepthShot> seen;
    for (std::uint64_t k = 0; k < shots; ++k)
        seen.push_back(render_shot(scene.bodies, cameras, {}, k, static_cast<double>(k) / 30.0));
    live::ShotRings rings(find_array("tile-10x10"), 40e3, scene.options);
    std::size_t next = 0, points = 0, foci = 0;
    const double least = bench::least_s(shots, [&] {
        live::ShotReport report;
        report.number = seen[next].number;
        report.time_s = seen[next].time_s;
        (void)rings.take(cameras, seen[next++], report);
        points = report.points;
        foci = report.foci;
    });
    return {{"ms", 1e3 * least}, {"points", points}, {"rings", foci}};
}

/// Milliseconds in which a ring's foci are weighed.
double weighed_ms(const Array& array) {
    const Vec3 at{0, 0, 0.15};
    const auto contact = contact_of({at, {0, 0, 1}, 8e-3}, at, {0, 0, -1});
    const std::vector<Vec3> places = ring_points(contact->section, 10);
    const auto form = form_of(*contact);
    RingWeigher weigher(array);
    double sum = 0.0;
    const double least = bench::least_s(200, [&] { sum += weigher.weigh(places, *form)->even_pa; });
    return sum > 0.0 ? 1e3 * least : -1.0;
}

}  // namespace

int main() {
    const Scene scene = hand_on_a_cube();
    const Vec3 target = scene.options.scene.pose.origin;
    DepthCamera below;  // 640 x 480
    below.pose = looking_at(target - Vec3{0, 0, 0.3}, target);
    nlohmann::ordered_json found;
    found["one_640"] = measured({below}, scene);
    found["four_848"] = measured(cameras_around(target, 0.3, 4), scene);
    found["weigh_tile"] = weighed_ms(find_array("tile-10x10"));
    found["weigh_cube"] = weighed_ms(joined(find_rig("cube-300")));
    fmt::print("{}\n", found.dump());
    return 0;
}
