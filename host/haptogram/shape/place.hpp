// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>

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

}  // namespace haptogram
