// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// A built-in shape; what is left out takes the shape's default. Lengths in metres.
struct PrimitiveSpec {
    std::string kind;
    std::optional<double> diameter{};
    std::optional<double> size{};  ///< length of an edge, of a line or of a plus sign's strokes
    std::optional<double> height{};
    std::optional<unsigned> sides{};
    std::optional<double> turns{};
};

/// Names of the built-in shapes.
[[nodiscard]] std::vector<std::string> primitive_kinds();

/// Makes a built-in shape, its bounding box centred on the origin, flat shapes in z = 0, others standing along z. Lines
/// are exact curves; surfaces are meshes within 4e-5 diameters of the true one. Solids have their end discs, the
/// hemisphere is the upper dome alone. The defaults are those of the Haptogram paper, section IV, where it has the
/// shape: a circle of 70 mm, a line of 100 mm, a hemisphere of radius 50 mm; all else is 100 mm.
/// @throws Error{bad_argument} for an unknown kind, an option that the shape does not take (naming those it takes), a
/// length or
///         number of turns that is not positive and finite, or sides not in 3…1000
[[nodiscard]] Shape make_primitive(const PrimitiveSpec& spec);

}  // namespace haptogram
