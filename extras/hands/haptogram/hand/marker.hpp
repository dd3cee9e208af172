// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "haptogram/hand/hand.hpp"

namespace haptogram {

/// A place in a camera's picture, pixels, from its upper left corner.
struct Pixel {
    double u = 0.0, v = 0.0;
};

/// A camera without distortion. Its three directions have length 1 and are at right angles.
struct PinholeCamera {
    Vec3 place;  ///< of the pinhole, metres
    Vec3 right{1, 0, 0}, down{0, -1, 0}, forward{0, 0, -1};
    double focal_px = 1000.0;
    double width_px = 1024.0, height_px = 768.0;

    /// Where a point is in the picture; nothing when it is outside, or behind the camera.
    [[nodiscard]] std::optional<Pixel> seen(Vec3 point) const;
    /// The direction in which a pixel looks, length 1.
    [[nodiscard]] Vec3 ray(Pixel pixel) const;
};

/// A camera that looks at a point, with the array's x axis level in its picture.
/// @param field_rad  angle across the width of the picture
/// @throws Error{bad_argument} when it stands at the point, looks along x, or the angle is not between 0 and π
[[nodiscard]] PinholeCamera camera_towards(Vec3 place, Vec3 target, double field_rad);

/// The point that is as near as possible to both cameras' rays: the middle of the shortest line between them.
/// @throws Error{bad_input} when the rays are parallel
[[nodiscard]] Vec3 triangulated(const PinholeCamera& first, Pixel in_first, const PinholeCamera& second,
                                Pixel in_second);

struct MarkerSample {
    double time_s = 0.0;
    Vec3 position;  ///< metres, array frame
};

/// A reflecting marker at the root of the middle finger, which two infrared cameras see (Hoshi et al. 2010, section
/// 4.2). The paper gives an accuracy of less than 1 mm. Pictures of 1024 × 768 at 100 a second, and the other measures,
/// are ours.
struct MarkerTracker {
    PinholeCamera first, second;
    double rate_hz = 100.0;
    double noise_px = 0.5;   ///< standard deviation of the marker's place in a picture, in each direction
    std::uint64_t seed = 1;  ///< of the noise
};

/// Two cameras beside each other that look at a point in the middle of the workspace from above.
/// @throws Error{bad_argument} as camera_towards()
[[nodiscard]] MarkerTracker usual_tracker(double baseline_m = 0.2, double range_m = 0.6, Vec3 target = {0, 0, 0.225});

struct MarkerTrack {
    std::vector<MarkerSample> samples;  ///< in ascending order of time
    std::size_t unseen = 0;             ///< times at which a camera did not see the marker, or there was no hand
};

/// What a tracker makes of a recording's first hand: at each of its times, the knuckle of the middle finger between the
/// recording's frames, in both pictures with noise, triangulated. A recording of one frame stands still for one sample.
/// @throws Error{bad_input} when the marker is never seen; Error{bad_argument} for a rate that is not positive
[[nodiscard]] MarkerTrack track_marker(const HandRecording& recording, const MarkerTracker& tracker);

}  // namespace haptogram
