// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "haptogram/format/path.hpp"
#include "haptogram/shape/parameters.hpp"

namespace haptogram {

/// Reads a pattern of the AdapTics designer (John et al., CHI 2024; doi:10.1145/3613904.3642090): key frames with a
/// place, a brush and an intensity each. Between them these change linearly or in a step; a pause holds the place, a
/// stop ends the pattern. A brush is a circle or a line, drawn 100 times a second around the place, times a cosine from
/// 0 to 1 at the brush's am_freq. The pattern is scaled, turned about z and moved as it says, and played at its speed.
/// Parameters have their default values, unless others are given. Jumps to the beginning end a pass. A template, which
/// has one key frame, plays for whole turns of its brush and, in a second at most, whole beats of its am_freq.
/// @param carrier_hz  of the board that is to play it
/// @param samples     even times at which the pattern is looked at, each in its middle
/// @param where       names the file in messages
/// @throws Error{bad_input} for what is no such file, naming the member, for a parameter that it does not have or that
/// is out of its range, and for what a path of fixed length cannot have: a random intensity, and a jump whose condition
/// holds to another time than the beginning
[[nodiscard]] Path path_from_adaptics(std::string_view text, const std::string& where, double carrier_hz,
                                      std::size_t samples, const Parameters& parameters = {});

/// How often a brush is drawn, Hz. Fewer samples a second than twice this do not show its shape.
inline constexpr double adaptics_brush_hz = 100.0;

}  // namespace haptogram
