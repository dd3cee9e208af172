// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/marker.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/feature.hpp"

namespace haptogram {
namespace {

/// The marker's place in a frame: the knuckle of the middle finger of its first hand.
std::optional<Vec3> marker_in(const HandFrame& frame) {
    if (frame.hands.empty() || !frame.hands.front().fingers[2]) return std::nullopt;
    return frame.hands.front().fingers[2]->joints[0];
}

}  // namespace

std::optional<Pixel> PinholeCamera::seen(Vec3 point) const {
    const Vec3 way = point - place;
    const double depth = dot(way, forward);
    if (!(depth > 0.0)) return std::nullopt;
    const Pixel pixel{0.5 * width_px + focal_px * dot(way, right) / depth,
                      0.5 * height_px + focal_px * dot(way, down) / depth};
    if (pixel.u < 0.0 || pixel.u > width_px || pixel.v < 0.0 || pixel.v > height_px) return std::nullopt;
    return pixel;
}

Vec3 PinholeCamera::ray(Pixel pixel) const {
    const Vec3 way = focal_px * forward + (pixel.u - 0.5 * width_px) * right + (pixel.v - 0.5 * height_px) * down;
    return way * (1.0 / norm(way));
}

PinholeCamera camera_towards(Vec3 place, Vec3 target, double field_rad) {
    if (!(field_rad > 0.0 && field_rad < std::numbers::pi))
        throw bad_argument("field", fmt::format("an angle of {} rad; expected one between 0 and π", field_rad));
    PinholeCamera camera;
    camera.place = place;
    const Vec3 way = target - place;
    if (!(norm(way) > 0.0)) throw bad_argument("camera", "it stands where it looks; place it elsewhere");
    camera.forward = way * (1.0 / norm(way));
    const Vec3 level = Vec3{1, 0, 0} - dot(camera.forward, {1, 0, 0}) * camera.forward;
    if (norm(level) < 1e-9) throw bad_argument("camera", "it looks along x, which must be level in its picture");
    camera.right = level * (1.0 / norm(level));
    camera.down = cross(camera.forward, camera.right);
    camera.focal_px = 0.5 * camera.width_px / std::tan(0.5 * field_rad);
    return camera;
}

Vec3 triangulated(const PinholeCamera& first, Pixel in_first, const PinholeCamera& second, Pixel in_second) {
    const Vec3 a = first.ray(in_first), b = second.ray(in_second);
    const Vec3 between = second.place - first.place;
    const double along = dot(a, b);
    const double apart = 1.0 - along * along;
    if (!(apart > 1e-12))
        throw bad_input("cameras", "their rays to the marker are parallel and meet nowhere; place the cameras apart");
    const double s = (dot(between, a) - along * dot(between, b)) / apart;
    const double t = (along * dot(between, a) - dot(between, b)) / apart;
    return 0.5 * (first.place + s * a + second.place + t * b);
}

MarkerTracker usual_tracker(double baseline_m, double range_m, Vec3 target) {
    constexpr double field_rad = 33.0 * std::numbers::pi / 180.0;
    // From above and from the side of the fingertips, 30° from the array's axis.
    const Vec3 middle = target + range_m * Vec3{0.0, 0.5, 0.5 * std::numbers::sqrt3};
    const Vec3 aside{0.5 * baseline_m, 0.0, 0.0};
    MarkerTracker tracker;
    tracker.first = camera_towards(middle - aside, target, field_rad);
    tracker.second = camera_towards(middle + aside, target, field_rad);
    return tracker;
}

MarkerTrack track_marker(const HandRecording& recording, const MarkerTracker& tracker) {
    if (!(tracker.rate_hz > 0.0) || !std::isfinite(tracker.rate_hz))
        throw bad_argument("rate",
                           fmt::format("found {}, expected a positive number of pictures a second", tracker.rate_hz));
    const auto& frames = recording.frames;
    if (frames.empty()) throw bad_input("recording", "it has no frame; take another recording");
    MarkerTrack track;
    Noise noise(tracker.seed);
    const double length_s = frames.back().time_s - frames.front().time_s;
    std::size_t frame = 0;
    for (std::size_t i = 0; static_cast<double>(i) / tracker.rate_hz <= length_s + 1e-9; ++i) {
        const double time_s = static_cast<double>(i) / tracker.rate_hz;
        const double at = frames.front().time_s + time_s;
        while (frame + 2 < frames.size() && frames[frame + 1].time_s <= at) ++frame;
        std::optional<Vec3> marker = marker_in(frames[frame]);
        if (frames.size() > 1) {
            const std::optional<Vec3> next = marker_in(frames[frame + 1]);
            const double share = (at - frames[frame].time_s) / (frames[frame + 1].time_s - frames[frame].time_s);
            if (marker && next)
                marker = *marker + share * (*next - *marker);
            else
                marker.reset();
        }
        const std::optional<Pixel> left = marker ? tracker.first.seen(*marker) : std::nullopt;
        const std::optional<Pixel> right = marker ? tracker.second.seen(*marker) : std::nullopt;
        if (!left || !right) {
            ++track.unseen;
            continue;
        }
        const auto noisy = [&](Pixel pixel) {
            pixel.u += tracker.noise_px * noise.normal();
            pixel.v += tracker.noise_px * noise.normal();
            return pixel;
        };
        const Pixel in_first = noisy(*left);
        track.samples.push_back({time_s, triangulated(tracker.first, in_first, tracker.second, noisy(*right))});
    }
    if (track.samples.empty())
        throw bad_input("recording", fmt::format("no camera pair ever sees the marker on the root of the middle finger "
                                                 "({} times); move the hand into the workspace",
                                                 track.unseen));
    return track;
}

}  // namespace haptogram
