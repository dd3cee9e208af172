// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "haptogram/hand/skin_line.hpp"
#include "haptogram/hand/solid.hpp"
#include "haptogram/hand/surface.hpp"

namespace haptogram {

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
