// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "haptogram/format/path.hpp"
#include "haptogram/shape/place.hpp"

namespace haptogram {

/// A shape that is strongest at one side: its foci's amplitude falls evenly along an axis, from 1 to a share at the
/// other side.
struct Fade {
    std::size_t axis = 0;    ///< x, y or z
    bool from_upper = true;  ///< strongest at the upper end of the axis, or at the lower one
    double share = 0.0;      ///< of the amplitude, at the other end: 0 to below 1, in millionths
    friend constexpr bool operator==(const Fade&, const Fade&) = default;
};

inline constexpr std::string_view fade_form =
    "the strongest side and the share of the amplitude at the other, 0 to .999999, such as left:0.5";
inline constexpr std::string_view fade_pattern = "^(left|right|front|back|below|above):(0|0?\\.[0-9]{1,6})$";

/// @param text  such as "left:0.5": strongest where x is least, half the amplitude where it is most; front is where y
/// is least
/// @return nothing for a text of another form
[[nodiscard]] std::optional<Fade> fade_of(std::string_view text);
/// What fade_of() reads back.
[[nodiscard]] std::string to_text(const Fade& fade);

/// Makes foci weaker by where they are; those that get no amplitude become silence.
/// @param box  that holds them, and whose sides the fade goes between
/// @throws Error{bad_argument} naming "fade" when the box has no extent along the axis
void apply(const Fade& fade, const Box& box, Path& path);

}  // namespace haptogram
