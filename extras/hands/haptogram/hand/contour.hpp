// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "haptogram/hand/solid.hpp"
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
/// shape/draw.hpp). More than `most_toured` lines stay as they are, because the search would take longer than a
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

/// How deep each point of a region's raster is in a solid, metres, positive inside.
struct DepthMap {
    std::vector<double> depth;  ///< one a point of the raster
    std::size_t deepest = 0;    ///< the number of the deepest point
    bool touched = false;       ///< some point is inside
};

/// What a depth map must be exact for. Anywhere else it has the right sign only, which is faster: the distance at one
/// point tells the sign of all points around it that are nearer than the surface.
enum class DepthFor { contour, inside };

[[nodiscard]] DepthMap depth_map(const SkinRegion& region, const Solid& solid, DepthFor use);

/// Where the depth is `level`: marching squares on the raster, linear between its points; a cell with two crossings is
/// split by the mean of its corners. Lines that leave the raster stay open (Shapes, algorithm A, steps 1 to 4; the
/// threshold and border of the paper are within a cell of this). The deeper side is on the left of the way, seen from
/// where columns lead to the right and rows up.
/// @param number  of the region, which the lines get
[[nodiscard]] std::vector<SkinLine> contours(const SkinRegion& region, const DepthMap& map, double level,
                                             std::size_t number, LineKind kind);

/// The deepest point of all regions; nothing when none is touched.
struct Deepest {
    SkinPoint at;
    double depth = 0.0;
    std::size_t region = 0;
};
[[nodiscard]] std::optional<Deepest> deepest_of(const std::vector<SkinRegion>& skin, const std::vector<DepthMap>& maps);

}  // namespace haptogram
