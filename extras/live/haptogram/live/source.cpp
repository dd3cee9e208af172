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
#include "haptogram/hand/open.hpp"
#include "haptogram/hand/render.hpp"
#include "haptogram/live/combined_source.hpp"
#include "haptogram/live/depth_folder.hpp"
#include "haptogram/live/depth_frames.hpp"
#include "haptogram/live/depth_pipe.hpp"
#include "haptogram/live/hand_source.hpp"

namespace haptogram::live {
namespace {

constexpr double finger_radius_m = 8e-3;
constexpr double press_s = 1.0;

/// Cameras whose poses are seen from a mounting.
class MountedDepth final : public DepthSource {
public:
    MountedDepth(std::unique_ptr<DepthSource> source, const Pose& mounting)
        : source_(std::move(source)), cameras_(source_->cameras()) {
        for (DepthCamera& camera : cameras_)
            camera.pose = {mounting.outwards(camera.pose.origin), mounting.turned(camera.pose.x),
                           mounting.turned(camera.pose.y), mounting.turned(camera.pose.z)};
    }
    [[nodiscard]] const std::vector<DepthCamera>& cameras() const override { return cameras_; }
    [[nodiscard]] double rate_hz() const override { return source_->rate_hz(); }
    [[nodiscard]] std::optional<DepthShot> next() override { return source_->next(); }
    [[nodiscard]] bool live() const override { return source_->live(); }
    [[nodiscard]] bool ready() override { return source_->ready(); }
    [[nodiscard]] std::pair<std::uint64_t, std::string> junk() const override { return source_->junk(); }

private:
    std::unique_ptr<DepthSource> source_;
    std::vector<DepthCamera> cameras_;
};

OpenedSource of_depth(std::unique_ptr<DepthSource> depth, const std::string& mounting = {}) {
    if (!mounting.empty())
        depth = std::make_unique<MountedDepth>(std::move(depth), mounting_from_toml(read_file(mounting), mounting));
    OpenedSource opened{std::make_unique<DepthFrames>(*depth)};
    opened.depth.push_back(std::move(depth));
    return opened;
}

}  // namespace

std::vector<DepthCamera> OpenedSource::cameras() const {
    std::vector<DepthCamera> all;
    for (const auto& source : depth) all.insert(all.end(), source->cameras().begin(), source->cameras().end());
    return all;
}

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
    const auto [file, mounting] = without_mounting(rest);
    if (kind == "depth") return of_depth(std::make_unique<DepthFolder>(file), mounting);
    if (kind == "depth-pipe") return of_depth(std::make_unique<DepthPipe>(file), mounting);
    if (name == "fingers:press")
        return of_depth(std::make_unique<SyntheticDepth>(
            cameras_of(cameras), [=](double time_s) { return pressing_fingers(time_s, object, half_m); },
            cameras.rate_hz, cameras.seconds > 0.0 ? cameras.seconds : press_s, cameras.noise));
    if (kind == "leap-pipe") {
        auto pipe = std::make_unique<HandPipe>(
            file, mounting.empty() ? Pose{} : mounting_from_toml(read_file(mounting), mounting));
        const HandPipe* const tracker = pipe.get();
        return {std::move(pipe), {}, {tracker}};
    }
    if (kind == "leap" || kind == "poses" || kind == "synthetic") {
        const std::string& recording = kind == "synthetic" ? name : rest;
        return {std::make_unique<RecordedHands>(open_hands(recording), recording, cameras.seconds)};
    }
    throw bad_argument("from", fmt::format("found \"{}\", expected depth:FOLDER, depth-pipe:FILE, leap:FILE, "
                                           "leap-pipe:FILE, poses:FILE, synthetic:SCRIPT or fingers:press",
                                           name));
}

OpenedSource open_sources(const std::vector<std::string>& names, const CameraOptions& cameras, Vec3 object,
                          double half_m) {
    if (names.size() == 1) return open_source(names.front(), cameras, object, half_m);
    OpenedSource all;
    std::vector<CombinedSource::Part> parts;
    for (const std::string& name : names) {
        OpenedSource one = open_source(name, cameras, object, half_m);
        parts.push_back({std::move(one.frames), one.cameras().size()});
        std::move(one.depth.begin(), one.depth.end(), std::back_inserter(all.depth));
        all.trackers.insert(all.trackers.end(), one.trackers.begin(), one.trackers.end());
    }
    all.frames = std::make_unique<CombinedSource>(std::move(parts), link::machine_clock());
    return all;
}

bool has_simulated_cameras(std::string_view name) { return name.starts_with("fingers:"); }

}  // namespace haptogram::live
