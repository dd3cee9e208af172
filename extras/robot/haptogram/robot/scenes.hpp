// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "haptogram/robot/feature_mode.hpp"
#include "haptogram/robot/palm_mode.hpp"
#include "haptogram/robot/together.hpp"

// Scenes for both modes of the paper Multimodal, section III: what `haptogram robot explore` and `robot tell` play.

namespace haptogram::fusion {

/// Mode W1: the ultrasound shows where an object's edges and corners meet the hand; the cables give the weight of what
/// is carried, and the friction and texture of a surface on which it can be put.
struct ExploreScene {
    TouchObject object;                            ///< array frame
    double weight_n = 1.0;                         ///< of what is carried
    Surface surface;                               ///< its height is above the array
    double tilt_deg = 0.0;                         ///< of the hand, fingers down
    double magnitude = 2.0, frequency_hz = 200.0;  ///< of each focus
    SliceOptions slice;
};
/// Where there are more points than a frame has time for, they take turns from frame to frame.
/// @param clock    of the frames
/// @param body_kg  of the virtual body that the surface carries (robot::AdmittanceOptions)
/// @throws Error{bad_argument} naming what makes no sense, such as a stiffness of the surface that would make the body
/// swing: stiffness · period² / body must be below 4
[[nodiscard]] Scene scene_of(const ExploreScene& explored, const SharedClock& clock, double body_kg = 1.0);

/// What a pattern on the palm tells.
enum class PalmValue { distance, texture, hardness };
/// "distance", "texture" or "hardness". @throws Error{bad_argument} naming "value"
[[nodiscard]] PalmValue palm_value(const std::string& name);

/// Mode W2: the cables give the weight; a pattern on the palm tells how near the hand is to a height, how rough a cloth
/// at that height is, or how hard it is. Of texture and hardness something is told only below the height, where the
/// hand has reached them. Ranges are ours.
struct TellScene {
    PalmPattern pattern;
    PalmValue value = PalmValue::distance;
    std::size_t points = 6;  ///< of a line or a ring; a focus is one
    double weight_n = 1.0;
    double height_m = 0.25;                           ///< above the array
    double range_m = 0.1;                             ///< of the distance
    double cell_m = 20e-3;                            ///< of the cloth's threads
    double stiffness_n_m = 500.0;                     ///< that is told
    double softest_n_m = 50.0, hardest_n_m = 5000.0;  ///< and the ends of its range
};
/// @throws Error{bad_argument} naming what makes no sense
[[nodiscard]] Scene scene_of(const TellScene& told);

}  // namespace haptogram::fusion
