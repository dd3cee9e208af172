// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/shape/key_frames.hpp"

namespace haptogram {

/// A pattern's key frames as those of a shape that moves.
struct AdapticsFrames {
    std::optional<double> diameter_m{};  ///< of the circle that its brush draws, at its widest; none: it is a point
    Vec3 centre{};                       ///< of the shape at the first key frame, metres
    std::vector<KeyFrame> frames{};
};

/// @throws Error{bad_input} as path_from_adaptics(), and that says why, for what a shape's key frames cannot say: a
/// line as a brush, a circle that becomes a point, a changing am_freq, and steps of one thing while another changes
/// evenly
[[nodiscard]] AdapticsFrames frames_from_adaptics(std::string_view text, const std::string& where);

}  // namespace haptogram
