// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <utility>

#include "haptogram/acoustics/grid.hpp"

namespace haptogram {

/// Where a field is wanted: a line, a plane or a volume along the axes.
struct Region {
    Grid grid;
    std::string axes;  ///< those with more than one coordinate, of "xyz", in this order
    std::string text;  ///< as it was asked for, such as "xy@z=130"
};

/// How far a region reaches, metres. An axis without a range reaches from −extent to +extent, z from one step above the
/// array to twice the extent.
struct Reach {
    double extent_m = 80e-3;
    double step_m = 1e-3;
    std::optional<std::pair<double, double>> x, y, z;
};

/// Reads "z@x=0,y=5" (a line), "xy@z=130" (a plane) or "xyz" (a volume), millimetres.
/// @param option  names it in messages
/// @throws Error{bad_argument} for a text that is none of these, points on or behind the array, or more than memory
/// holds
[[nodiscard]] Region parse_region(const std::string& option, const std::string& text, const Reach& reach);

/// Reads "-40:40", millimetres. @throws Error{bad_argument} naming `option`
[[nodiscard]] std::pair<double, double> parse_range(const std::string& option, const std::string& text);

}  // namespace haptogram
