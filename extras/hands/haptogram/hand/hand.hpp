// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// A finger as a chain of three straight segments, metres.
struct Finger {
    std::array<Vec3, 4> joints;     ///< knuckle (mcp), middle joint (pip), end joint (dip), tip
    std::optional<double> width_m;  ///< where a recording says it
};

/// A hand at one time, array frame.
struct Hand {
    std::int64_t id = 0;  ///< the same as long as a tracker sees it
    bool right = true;
    Vec3 palm;                                     ///< centre of the palm, metres
    Vec3 normal{0.0, 0.0, -1.0};                   ///< out of the palm, length 1
    Vec3 direction{0.0, 1.0, 0.0};                 ///< from the palm to the fingers, length 1
    Vec3 velocity;                                 ///< of the palm, m/s
    double confidence = 1.0;                       ///< of the tracker, 0 to 1
    double grab = 0.0, pinch = 0.0;                ///< how far the hand is closed, 0 to 1
    std::array<std::optional<Finger>, 5> fingers;  ///< thumb, index, middle, ring, pinkie
    std::optional<double> seen_s{};                ///< when it was seen, if that is not the time of its frame
};

struct HandFrame {
    double time_s = 0.0;  ///< since the recording's first frame
    std::vector<Hand> hands;
};

struct HandRecording {
    std::vector<HandFrame> frames;  ///< in ascending order of time
};

}  // namespace haptogram
