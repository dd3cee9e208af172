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
#include "haptogram/live/frame.hpp"
#include "haptogram/live/hand_source.hpp"

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

/// Where frames come from, as a user names it.
struct OpenedSource {
    std::unique_ptr<FrameSource> frames;
    std::vector<std::unique_ptr<DepthSource>> depth{};  ///< behind them; none of trackers' hands
    std::vector<const HandPipe*> trackers{};            ///< among them, those that come as it happens
    [[nodiscard]] bool only_hands() const { return depth.empty(); }
    /// Of all that are depth, in their order.
    [[nodiscard]] std::vector<DepthCamera> cameras() const;
};
/// - depth:FOLDER   a recording (live/depth_folder.hpp)
/// - depth-pipe:FILE   cameras of another program (live/depth_pipe.hpp); - is standard input
/// - fingers:press   scripted fingers at the object, which simulated cameras see
/// - leap-pipe:FILE   hands of another program (live/hand_source.hpp)
/// - leap:FILE, poses:FILE   recorded hands; also synthetic:SCRIPT[:HEIGHT] as render has it
/// @MOUNTING behind a file says where the tracker, or the frame of all of the cameras, is (hand/mounting.hpp).
/// @param cameras  the simulated ones; of a recording of hands only their `seconds` count
/// @param object  its middle, @param half_m half of its edge, for scripted fingers
/// @throws Error{bad_input} for files that cannot be used, Error{bad_argument} for other names
[[nodiscard]] OpenedSource open_source(const std::string& name, const CameraOptions& cameras, Vec3 object,
                                       double half_m);
/// Several of them as one (live/combined_source.hpp); one as it is.
/// @throws Error{bad_argument} when there is none, or when recordings are among what comes as it happens
[[nodiscard]] OpenedSource open_sources(const std::vector<std::string>& names, const CameraOptions& cameras,
                                        Vec3 object, double half_m);
/// Whether a source of this name is seen by simulated cameras.
[[nodiscard]] bool has_simulated_cameras(std::string_view name);

}  // namespace haptogram::live
