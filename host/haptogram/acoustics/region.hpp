// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <utility>

#include "haptogram/acoustics/grid.hpp"

namespace haptogram {

/// The points at which a field is wanted: a line, a plane or a volume along the axes.
struct Region {
    Grid grid;
    std::string axes;  ///< those along which the points spread, in this order: "x", "xz", "xyz", …
    std::string text;  ///< as it was asked for, such as "xy@z=130"
};

/// The size of a region and the distance between its points, metres. An axis with a range spreads over that range. Any
/// other spreads from −extent to +extent; but z, which begins at the array, from one step to twice the extent.
struct Reach {
    double extent_m = 80e-3;
    double step_m = 1e-3;
    std::optional<std::pair<double, double>> x, y, z;
};

/// Reads the text of a region, millimetres: "z@x=0,y=5" is a line, "xy@z=130" a plane, "xyz" the volume.
/// @param setting  that the text is the value of, for messages
/// @throws Error{bad_argument} naming `setting` when the text is none of these, or has points at or below z = 0; naming
/// "step" when the step does not suit the extent, or the points need more memory than this machine has
[[nodiscard]] Region parse_region(const std::string& setting, const std::string& text, const Reach& reach);

/// Reads a range such as "-40:40", millimetres, and returns it in metres.
/// @throws Error{bad_argument} naming `setting`
[[nodiscard]] std::pair<double, double> parse_range(const std::string& setting, const std::string& text);

}  // namespace haptogram
