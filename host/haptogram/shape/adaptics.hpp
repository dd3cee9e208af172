// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/shape/key_frames.hpp"

namespace haptogram {

/// Reads a pattern of the AdapTics designer (John et al., CHI 2024; doi:10.1145/3613904.3642090): key frames with a
/// place, a brush and an intensity each. Between them these change linearly or in a step; a pause holds the place, a
/// stop ends the pattern. A brush is a circle or a line, drawn 100 times a second around the place, times a cosine from
/// 0 to 1 at the brush's am_freq. The pattern is scaled, turned about z and moved as it says, and played at its speed.
/// Parameters have their default values.
/// @param carrier_hz  of the board that is to play it
/// @param samples     even times at which the pattern is looked at, each in its middle
/// @param where       names the file in messages
/// @throws Error{bad_input} for what is no such file, naming the member, and for what a path of fixed length cannot
/// have: a jump whose condition holds, a random intensity, a formula of parameters
[[nodiscard]] Path path_from_adaptics(std::string_view text, const std::string& where, double carrier_hz,
                                      std::size_t samples);

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

/// How often a brush is drawn, Hz. Fewer samples a second than twice this do not show its shape.
inline constexpr double adaptics_brush_hz = 100.0;

}  // namespace haptogram
