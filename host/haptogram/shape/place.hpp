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

/// How a shape is put into the array frame; the steps in the order of the members.
struct Placement {
    double scale = 1.0;              ///< about the origin
    std::optional<double> size_m{};  ///< the largest extent of the bounding box, which keeps its centre
    std::array<double, 3>
        rotate_deg{};              ///< about the bounding box' centre: about the x, then y, then z axis, right-handed
    std::optional<Vec3> center{};  ///< where the bounding box' centre goes, metres
};

/// The smallest box along the axes that holds the shape, metres; curves to 1e-9 of their length.
/// @throws Error{bad_argument} for a shape without points
[[nodiscard]] Box bounding_box(const Shape& shape);

/// @throws Error{bad_argument} when a scale or size is not positive and finite, an angle or centre is not finite, or a
/// shape
///         without extent is to get a size
[[nodiscard]] Shape place(const Shape& shape, const Placement& placement);

}  // namespace haptogram
