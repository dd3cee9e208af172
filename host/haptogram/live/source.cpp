// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/live/depth_folder.hpp"
#include "haptogram/live/depth_pipe.hpp"
#include "haptogram/live/leap_pipe.hpp"
#include "haptogram/verbs/render.hpp"

namespace haptogram::live {
namespace {

constexpr double finger_radius_m = 8e-3;
constexpr double press_s = 1.0;

}  // namespace

std::vector<DepthCamera> cameras_of(const CameraOptions& options) {
    if (options.count != 1) return cameras_around(options.target, options.distance_m, options.count);
    DepthCamera below = wide_depth_camera();
    below.pose = looking_at(options.target - Vec3{0, 0, options.distance_m}, options.target);
    return {below};
}

std::vector<RoundedBody> pressing_fingers(double time_s, Vec3 object, double half_m) {
    const double depth = 4.5e-3 - 5.5e-3 * std::cos(2.0 * std::numbers::pi * time_s / press_s);
    std::vector<RoundedBody> fingers;
    for (const double side : {-0.5, 0.5})
        fingers.push_back({object + Vec3{side * half_m, 0, half_m + finger_radius_m - depth + 25e-3},
                           {0, 0, 25e-3},
                           {},
                           finger_radius_m});
    return fingers;
}

std::vector<RoundedBody> bodies_at(const HandRecording& recording, double time_s) {
    const auto after = std::upper_bound(recording.frames.begin(), recording.frames.end(), time_s,
                                        [](double time, const HandFrame& frame) { return time < frame.time_s; });
    std::vector<RoundedBody> bodies;
    if (after == recording.frames.begin()) return bodies;
    for (const Hand& hand : std::prev(after)->hands) {
        const std::vector<RoundedBody> of_hand = bodies_of(hand);
        bodies.insert(bodies.end(), of_hand.begin(), of_hand.end());
    }
    return bodies;
}

std::unique_ptr<DepthSource> open_depth(const std::string& name, const CameraOptions& cameras, Vec3 object,
                                        double half_m) {
    const std::size_t colon = std::min(name.find(':'), name.size());
    const std::string kind = name.substr(0, colon), rest = colon < name.size() ? name.substr(colon + 1) : "";
    if (kind == "depth") return std::make_unique<DepthFolder>(rest);
    if (kind == "depth-pipe") return std::make_unique<DepthPipe>(rest);
    if (kind == "leap-pipe")
        return std::make_unique<LeapPipe>(rest, cameras_of(cameras), cameras.rate_hz, cameras.noise);
    const auto simulated = [&](SyntheticDepth::Scene scene, double seconds) {
        return std::make_unique<SyntheticDepth>(cameras_of(cameras), std::move(scene), cameras.rate_hz,
                                                cameras.seconds > 0.0 ? cameras.seconds : seconds, cameras.noise);
    };
    if (kind == "fingers") {
        if (rest != "press") throw bad_argument("from", fmt::format("found \"{}\", expected fingers:press", name));
        return simulated([=](double time_s) { return pressing_fingers(time_s, object, half_m); }, press_s);
    }
    if (kind == "leap" || kind == "poses" || kind == "synthetic") {
        auto hands = std::make_shared<const HandRecording>(open_hands(kind == "synthetic" ? name : rest));
        if (hands->frames.empty()) throw bad_input(name, "there is no hand in it");
        return simulated([hands](double time_s) { return bodies_at(*hands, time_s); }, hands->frames.back().time_s);
    }
    throw bad_argument("from", fmt::format("found \"{}\", expected depth:FOLDER, depth-pipe:FILE, leap:FILE, "
                                           "leap-pipe:FILE, poses:FILE, synthetic:SCRIPT or fingers:press",
                                           name));
}

bool has_cameras(std::string_view name) { return name.starts_with("depth:") || name.starts_with("depth-pipe:"); }

}  // namespace haptogram::live
