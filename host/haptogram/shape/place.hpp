// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/shape/shape.hpp"

namespace haptogram {

struct Box {
    Vec3 low, high;

    [[nodiscard]] Vec3 center() const { return 0.5 * (low + high); }
    [[nodiscard]] Vec3 extent() const { return high - low; }
};

/// Where a shape goes in the array frame. The steps are taken in the order of the members.
struct Placement {
    double scale = 1.0;                  ///< about the origin
    std::optional<double> size_m{};      ///< wanted largest extent of the bounding box, whose centre stays
    std::array<double, 3> rotate_deg{};  ///< about the x, then the y, then the z axis through the centre, right-handed
    std::optional<Vec3> center{};        ///< where the centre of the bounding box goes, metres
    friend bool operator==(const Placement&, const Placement&) = default;
};

/// The smallest box along the axes that holds the shape, metres; curves to 1e-9 of their length.
/// @throws Error{bad_argument} for a shape without points
[[nodiscard]] Box bounding_box(const Shape& shape);

/// @throws Error{bad_argument} that names the setting: `scale` or `size` that is not positive and finite, `rotate` or
///         `center` that is not finite, or `size` for a shape without extent
[[nodiscard]] Shape placed_at(const Shape& shape, const Placement& placement);

/// @throws Error{bad_input} that lists the foci of a path that are out of the array's reach
void require_reachable(const Path& path, const Array& array);

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
