// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/hand/surface.hpp"

namespace haptogram {

/// What a line on the skin stands for.
enum class LineKind { contour, feature, solid, grain, blob, pointer, press };
[[nodiscard]] const char* name_of(LineKind kind);

/// A line on the skin, straight from point to point.
struct SkinLine {
    std::vector<SkinPoint> points;
    bool closed = false;  ///< a last line leads back to the first point
    LineKind kind = LineKind::contour;
    std::size_t region = 0;  ///< in the list of the skin's regions
};

/// Metres.
[[nodiscard]] double length_of(const SkinLine& line);
[[nodiscard]] double length_of(const std::vector<SkinLine>& lines);

/// The lines in an order with short jumps: open ones drawn from either end, closed ones begun anywhere (curve_tour() of
/// shape/curve.hpp). More than `most_toured` lines stay as they are, because the search would take longer than a
/// frame. Lines of no length are left out: there is nothing to draw.
[[nodiscard]] std::vector<SkinLine> toured(std::vector<SkinLine> lines);
inline constexpr std::size_t most_toured = 40;

/// The points of a closed line and, once more, its first.
[[nodiscard]] std::vector<SkinPoint> opened(const SkinLine& line);

/// Between two places: a share of the way.
[[nodiscard]] SkinPoint between(const SkinPoint& a, const SkinPoint& b, double share);

/// What is left of lines after every part is cut away that is nearer than `gap` to one of the points: the gap rule of
/// Shapes, algorithm H. Lines are cut where they cross the distance `gap`, to within the straight lines' own points.
[[nodiscard]] std::vector<SkinLine> away_from(const std::vector<SkinLine>& lines, const std::vector<Vec3>& points,
                                              double gap);

/// Points along lines, at most `step` apart.
[[nodiscard]] std::vector<Vec3> points_along(const std::vector<SkinLine>& lines, double step);

}  // namespace haptogram
