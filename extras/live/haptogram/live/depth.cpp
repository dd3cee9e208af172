// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/depth.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

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

}  // namespace haptogram
