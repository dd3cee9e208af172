// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// A built-in shape and its measures, in metres. A measure that is left out takes the shape's default.
struct PrimitiveSpec {
    std::string kind;
    std::optional<double> diameter{};
    std::optional<double> length{};  ///< of an edge, of a line or of a plus sign's strokes
    std::optional<double> height{};
    std::optional<unsigned> sides{};
    std::optional<double> turns{};
};

/// Names of the built-in shapes.
[[nodiscard]] std::vector<std::string> primitive_kinds();

/// Makes a built-in shape. Its bounding box is centred on the origin; flat shapes lie in z = 0, others stand along z.
/// Lines are exact curves. Surfaces are meshes that lie within 4e-5 diameters of the true surface. Cones and cylinders
/// have their end discs; the hemisphere is the upper dome alone. Where the Haptogram paper (section IV) shows a shape,
/// its size there is the default: a circle of 70 mm, a line of 100 mm, a hemisphere of 50 mm radius. The helix is 70 mm
/// wide; all other defaults are 100 mm.
/// @throws Error{bad_argument} that names the setting: `shape` when the kind is unknown, or the measure that the shape
///         does not take, that is not positive and finite, or, of `sides`, not in 3…1000
[[nodiscard]] Shape make_primitive(const PrimitiveSpec& spec);

/// Throws what make_primitive() would.
void check_primitive(const PrimitiveSpec& spec);

}  // namespace haptogram
