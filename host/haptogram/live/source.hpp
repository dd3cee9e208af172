// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/hand/hand.hpp"
#include "haptogram/live/depth.hpp"
#include "haptogram/live/depth_renderer.hpp"

namespace haptogram::live {

/// Cameras that are simulated, where a source has none of its own.
struct CameraOptions {
    std::size_t count = 4;    ///< around the object, as in Fingers; 1: below it, looking up, as in its first experiment
    double distance_m = 0.3;  ///< from the object
    Vec3 target{0, 0, 0.2};   ///< what they look at
    double rate_hz = 30.0;
    double seconds = 0.0;  ///< 0: as long as the recording or script is
    DepthNoise noise;
};

/// The cameras of these options.
[[nodiscard]] std::vector<DepthCamera> cameras_of(const CameraOptions& options);

/// Two round upright fingers of 8 mm that press on the top of an object and let go, once a second.
/// @param object  its middle @param half_m  half of its edge
[[nodiscard]] std::vector<RoundedBody> pressing_fingers(double time_s, Vec3 object, double half_m);

/// The hands of a recording at a time: those of the last frame before it.
[[nodiscard]] std::vector<RoundedBody> bodies_at(const HandRecording& recording, double time_s);

/// Where depth comes from, as a user names it:
/// - depth:FOLDER   a recording (live/depth_folder.hpp)
/// - depth-pipe:FILE   cameras of another program (live/depth_pipe.hpp); - is standard input
/// - leap-pipe:FILE   hands of another program (leap_pipe.hpp), which simulated cameras see
/// - leap:FILE, poses:FILE   recorded hands, which simulated cameras see; also synthetic:SCRIPT[:HEIGHT] as render has
/// it
/// - fingers:press   scripted fingers at the object
/// @param cameras  the simulated ones; of no meaning to a source that has its own
/// @param object  its middle, @param half_m half of its edge, for scripted fingers
/// @throws Error{bad_input} for files that cannot be used, Error{bad_argument} for other names
[[nodiscard]] std::unique_ptr<DepthSource> open_depth(const std::string& name, const CameraOptions& cameras,
                                                      Vec3 object, double half_m);
/// Whether a source of this name has cameras of its own.
[[nodiscard]] bool has_cameras(std::string_view name);

}  // namespace haptogram::live
