// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/depth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/hand/feature.hpp"

namespace haptogram {

void require_sound(const DepthCamera& camera) {
    if (camera.width < 1 || camera.height < 1 || camera.width > 65535 || camera.height > 65535)
        throw bad_argument("camera", fmt::format("a picture of {} x {}; expected 1 to 65535 pixels in each direction",
                                                 camera.width, camera.height));
    require_positive("focal length", camera.focal_x_px);
    require_positive("focal length", camera.focal_y_px);
    require_positive("unit", camera.unit_m);
    require_positive("baseline", camera.baseline_m);
    if (!std::isfinite(camera.centre_x_px) || !std::isfinite(camera.centre_y_px) || !is_finite(camera.pose.origin))
        throw bad_argument("camera", "its principal point or its place is not finite");
}

DepthCamera wide_depth_camera() {
    DepthCamera camera;
    camera.width = 848;
    camera.height = 480;
    camera.focal_x_px = camera.focal_y_px = 446.8;
    camera.centre_x_px = 423.5;
    camera.centre_y_px = 239.5;
    return camera;
}

Pose looking_at(Vec3 place, Vec3 target) {
    const Vec3 way = target - place;
    if (!(norm(way) > 0.0)) throw bad_argument("camera", "it stands where it looks; place it elsewhere");
    Pose pose;
    pose.origin = place;
    pose.z = way * (1.0 / norm(way));
    Vec3 down = Vec3{0, 0, -1} + pose.z.z * pose.z;
    if (norm(down) < 1e-6) down = Vec3{0, -1, 0} + pose.z.y * pose.z;
    pose.y = down * (1.0 / norm(down));
    pose.x = cross(pose.y, pose.z);
    return pose;
}

std::vector<DepthCamera> cameras_around(Vec3 target, double distance_m, std::size_t count) {
    if (count == 0) throw bad_argument("cameras", "none; expected at least one");
    if (!(distance_m > 0.0)) throw bad_argument("distance", fmt::format("found {}, expected more than 0", distance_m));
    std::vector<DepthCamera> cameras(count, wide_depth_camera());
    for (std::size_t i = 0; i < count; ++i) {
        const double angle =
            2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count) - 0.5 * std::numbers::pi;
        cameras[i].pose = looking_at(target + distance_m * Vec3{std::cos(angle), std::sin(angle), 0}, target);
    }
    return cameras;
}

namespace {

constexpr double hit_m = 1e-6;  ///< a ray has met a surface when it is no farther from it

/// A body in a camera's frame.
struct SeenBody {
    RoundedBody body;
    double per_a2, per_b2;  ///< 1 over the squares of the half lengths; 0 for none

    [[nodiscard]] double distance_to(Vec3 p) const {
        const Vec3 way = p - body.middle;
        const double a = std::clamp(dot(way, body.half_a) * per_a2, -1.0, 1.0);
        const double b = std::clamp(dot(way, body.half_b) * per_b2, -1.0, 1.0);
        return norm(way - a * body.half_a - b * body.half_b) - body.radius;
    }
};

/// Pixels from the first to before the last.
struct Rectangle {
    std::uint32_t first_u = 0, last_u = 0, first_v = 0, last_v = 0;
};

double inverse_square(Vec3 v) { return dot(v, v) > 0.0 ? 1.0 / dot(v, v) : 0.0; }

Vec3 turned_inwards(const Pose& pose, Vec3 d) { return {dot(d, pose.x), dot(d, pose.y), dot(d, pose.z)}; }

SeenBody seen_by(const DepthCamera& camera, const RoundedBody& body) {
    if (!is_finite(body.middle) || !is_finite(body.half_a) || !is_finite(body.half_b) || !(body.radius > 0.0))
        throw bad_argument("body", "it is not finite, or its radius is not positive");
    RoundedBody seen{camera.pose.inwards(body.middle), turned_inwards(camera.pose, body.half_a),
                     turned_inwards(camera.pose, body.half_b), body.radius};
    return {seen, inverse_square(seen.half_a), inverse_square(seen.half_b)};
}

/// Where in the picture a body can be: around the balls at its corners, whose hull it is.
Rectangle around(const RoundedBody& body, const DepthCamera& camera) {
    double low_u = 1e9, high_u = -1e9, low_v = 1e9, high_v = -1e9;
    const double r = body.radius;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-1.0, 1.0}) {
            const Vec3 p = body.middle + a * body.half_a + b * body.half_b;
            if (p.z - r < 1e-3) return {0, camera.width, 0, camera.height};
            for (const double z : {p.z - r, p.z + r}) {
                low_u = std::min(low_u, camera.centre_x_px + camera.focal_x_px * (p.x - r) / z);
                high_u = std::max(high_u, camera.centre_x_px + camera.focal_x_px * (p.x + r) / z);
                low_v = std::min(low_v, camera.centre_y_px + camera.focal_y_px * (p.y - r) / z);
                high_v = std::max(high_v, camera.centre_y_px + camera.focal_y_px * (p.y + r) / z);
            }
        }
    const auto pixel = [](double x, std::uint32_t most) {
        return static_cast<std::uint32_t>(std::clamp(x, 0.0, static_cast<double>(most)));
    };
    return {pixel(std::floor(low_u), camera.width), pixel(std::ceil(high_u) + 1.0, camera.width),
            pixel(std::floor(low_v), camera.height), pixel(std::ceil(high_v) + 1.0, camera.height)};
}

/// The depth at which a ray from the camera meets a body, by steps as long as the way to its surface; `beyond` when it
/// does not, or not before that.
double depth_along(Vec3 ray, const SeenBody& seen, double beyond) {
    const double length = norm(ray);
    const double middle = norm(seen.body.middle);
    const double extent = norm(seen.body.half_a) + norm(seen.body.half_b) + seen.body.radius;
    const double behind = std::min(beyond, (middle + extent) / length);
    double z = std::max(0.0, (middle - extent) / length);
    for (int step = 0; step < 200 && z < behind; ++step) {
        const double free = seen.distance_to(z * ray);
        if (free < hit_m) return z;
        z += free / length;
    }
    return beyond;
}

void add_noise(std::vector<double>& depths, const DepthCamera& camera, const DepthNoise& noise, std::uint64_t stream) {
    Noise random(noise.seed * 0x9E3779B97F4A7C15U + stream);
    const std::vector<double> exact = depths;
    const auto edge = [&](double z, std::size_t other) {
        return !std::isfinite(exact[other]) || std::abs(exact[other] - z) > noise.edge_m;
    };
    for (std::uint32_t v = 0; v < camera.height; ++v)
        for (std::uint32_t u = 0; u < camera.width; ++u) {
            const std::size_t at = std::size_t{v} * camera.width + u;
            const double z = exact[at];
            if (!std::isfinite(z)) continue;
            const bool beside_edge = (u > 0 && edge(z, at - 1)) || (u + 1 < camera.width && edge(z, at + 1)) ||
                                     (v > 0 && edge(z, at - camera.width)) ||
                                     (v + 1 < camera.height && edge(z, at + camera.width));
            depths[at] += z * z * noise.disparity_px / (camera.focal_x_px * camera.baseline_m) * random.normal();
            if (beside_edge && random.uniform() < noise.edge_loss) depths[at] = HUGE_VAL;
        }
}

}  // namespace

std::vector<RoundedBody> bodies_of(const Hand& hand, const SkinOptions& skin) {
    std::vector<RoundedBody> bodies;
    for (const SkinRegion& region : palmar_surface(hand, skin))
        for (const SkinPatch& patch : region.patches) {
            const Vec3 half = 0.5 * patch.length * patch.along;
            if (patch.radius > 0.0)
                bodies.push_back({patch.from + half, half, {}, patch.radius});
            else  // the palm's skin is on the rounded plate
                bodies.push_back({patch.from + half - 0.5 * patch.thickness * patch.out, half,
                                  0.5 * patch.width * patch.side, 0.5 * patch.thickness});
        }
    return bodies;
}

DepthPicture render_depth(const std::vector<RoundedBody>& bodies, const DepthCamera& camera, const DepthNoise& noise,
                          std::uint64_t stream) {
    require_sound(camera);
    if (!(noise.disparity_px >= 0.0 && noise.edge_loss >= 0.0 && noise.edge_loss <= 1.0 && noise.edge_m > 0.0))
        throw bad_argument("noise", "its measures must not be negative, and the loss at edges not above 1");
    std::vector<double> depths(std::size_t{camera.width} * camera.height, HUGE_VAL);
    for (const RoundedBody& body : bodies) {
        const SeenBody seen = seen_by(camera, body);
        const Rectangle part = around(seen.body, camera);
        for (std::uint32_t v = part.first_v; v < part.last_v; ++v)
            for (std::uint32_t u = part.first_u; u < part.last_u; ++u) {
                double& depth = depths[std::size_t{v} * camera.width + u];
                depth = depth_along(
                    {(u - camera.centre_x_px) / camera.focal_x_px, (v - camera.centre_y_px) / camera.focal_y_px, 1.0},
                    seen, depth);
            }
    }
    if (noise.disparity_px > 0.0 || noise.edge_loss > 0.0) add_noise(depths, camera, noise, stream);
    DepthPicture picture(depths.size(), 0);
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double counts = std::round(depths[i] / camera.unit_m);
        if (counts >= 1.0 && counts <= 65535.0) picture[i] = static_cast<std::uint16_t>(counts);
    }
    return picture;
}

DepthShot render_shot(const std::vector<RoundedBody>& bodies, const std::vector<DepthCamera>& cameras,
                      const DepthNoise& noise, std::uint64_t number, double time_s) {
    DepthShot shot{number, time_s, {}};
    for (std::size_t i = 0; i < cameras.size(); ++i)
        shot.pictures.emplace_back(render_depth(bodies, cameras[i], noise, number * cameras.size() + i));
    return shot;
}

SyntheticDepth::SyntheticDepth(std::vector<DepthCamera> cameras, Scene scene, double rate_hz, double seconds,
                               const DepthNoise& noise)
    : cameras_(std::move(cameras)), scene_(std::move(scene)), rate_hz_(rate_hz), noise_(noise) {
    if (cameras_.empty()) throw bad_argument("cameras", "none; expected at least one");
    if (!(rate_hz > 0.0 && seconds > 0.0 && seconds * rate_hz < 1e9))
        throw bad_argument("rate", fmt::format("{} shots a second for {} s; expected more than 0", rate_hz, seconds));
    shots_ = static_cast<std::uint64_t>(std::llround(seconds * rate_hz));
}

std::optional<DepthShot> SyntheticDepth::next() {
    if (number_ == shots_) return {};
    const double time_s = static_cast<double>(number_) / rate_hz_;
    DepthShot shot = render_shot(scene_(time_s), cameras_, noise_, number_, time_s);
    ++number_;
    return shot;
}

}  // namespace haptogram
