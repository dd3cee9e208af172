// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptogram/hand/contour.hpp"
#include "haptogram/hand/skin_line.hpp"
#include "haptogram/hand/surface.hpp"

namespace haptogram {

/// Short random lines on the skin inside an object. The paper names them; their measures are ours.
struct GrainOptions {
    double spacing_m = 6e-3;  ///< a line for each square, or each cube, of this edge
    double length_m = 4e-3;
    std::size_t points = 5;  ///< of a line
    std::uint64_t seed = 1;
};

/// Other lines at every time (Shapes, algorithm E): each square of the raster whose middle is inside gets a line, which
/// begins at a random place of the square and turns at random, as far as the raster goes.
[[nodiscard]] std::vector<SkinLine> random_grain(const SkinRegion& region, const DepthMap& map, double time_s,
                                                 std::size_t number, const GrainOptions& options);

/// Lines that stay where they are in space (Shapes, algorithm F): each cube of a lattice in which the skin is inside
/// gets a line in the cube that only depends on the cube and the seed, laid onto the skin. A hand that does not move
/// feels the same lines again.
[[nodiscard]] std::vector<SkinLine> fixed_grain(const SkinRegion& region, const DepthMap& map, std::size_t number,
                                                const GrainOptions& options);

}  // namespace haptogram
