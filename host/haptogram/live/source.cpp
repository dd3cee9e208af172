// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/mounting.hpp"
#include "haptogram/live/depth_folder.hpp"
#include "haptogram/live/depth_frames.hpp"
#include "haptogram/live/depth_pipe.hpp"
#include "haptogram/live/hand_source.hpp"
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

OpenedSource open_source(const std::string& name, const CameraOptions& cameras, Vec3 object, double half_m) {
    const std::size_t colon = std::min(name.find(':'), name.size());
    const std::string kind = name.substr(0, colon), rest = colon < name.size() ? name.substr(colon + 1) : "";
    const auto of_depth = [](std::unique_ptr<DepthSource> depth) {
        auto frames = std::make_unique<DepthFrames>(*depth);
        return OpenedSource{std::move(frames), std::move(depth)};
    };
    if (kind == "depth") return of_depth(std::make_unique<DepthFolder>(rest));
    if (kind == "depth-pipe") return of_depth(std::make_unique<DepthPipe>(rest));
    if (name == "fingers:press")
        return of_depth(std::make_unique<SyntheticDepth>(
            cameras_of(cameras), [=](double time_s) { return pressing_fingers(time_s, object, half_m); },
            cameras.rate_hz, cameras.seconds > 0.0 ? cameras.seconds : press_s, cameras.noise));
    if (kind == "leap-pipe") {
        const auto [file, mounting] = without_mounting(rest);
        return {std::make_unique<HandPipe>(
                    file, mounting.empty() ? Pose{} : mounting_from_toml(read_file(mounting), mounting)),
                {}};
    }
    if (kind == "leap" || kind == "poses" || kind == "synthetic") {
        const std::string& file = kind == "synthetic" ? name : rest;
        return {std::make_unique<RecordedHands>(open_hands(file), file, cameras.seconds), {}};
    }
    throw bad_argument("from", fmt::format("found \"{}\", expected depth:FOLDER, depth-pipe:FILE, leap:FILE, "
                                           "leap-pipe:FILE, poses:FILE, synthetic:SCRIPT or fingers:press",
                                           name));
}

bool has_simulated_cameras(std::string_view name) { return name.starts_with("fingers:"); }

}  // namespace haptogram::live
