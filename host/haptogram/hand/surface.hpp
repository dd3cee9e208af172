// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "haptogram/hand/hand.hpp"

namespace haptogram {

/// A part of the palmar skin as a raster: cells of rows and columns, about square.
struct SkinRegion {
    std::string_view name;      ///< thumb, index, middle, ring, pinkie or palm
    std::size_t rows = 0;       ///< of a finger: along it, from the knuckle to the tip; of the palm: to the fingers
    std::size_t columns = 0;    ///< of a finger: around it, over half a turn
    std::vector<Vec3> points;   ///< row by row, array frame, metres
    std::vector<Vec3> normals;  ///< out of the skin, length 1
    [[nodiscard]] const Vec3& point(std::size_t row, std::size_t column) const {
        return points[row * columns + column];
    }
};

/// Measures of the hand where a recording has none; the cells' size. Metres.
struct SkinOptions {
    std::array<double, 3> finger_radii_m{9.5e-3, 8.5e-3, 7.5e-3};  ///< of the three segments
    std::array<double, 3> thumb_radii_m{10.5e-3, 9.5e-3, 8.5e-3};  ///< of the three segments
    double palm_width_m = 85e-3, palm_length_m = 90e-3;
    double cell_m = 1e-3;  ///< neighbours in a raster are at most this far apart
};

/// The palmar surface of a hand. A finger is a chain of three round segments; the half of their surface whose normals
/// have no negative product with the palm's normal is unrolled to a raster, by arc length along the chain and by angle
/// around it. When a recording says how wide the finger is, its radii are scaled so that the middle segment is. The
/// palm is a rectangle around its centre, along the hand's direction and across it. Fingers that the tracker did not
/// see are left out.
/// @throws Error{bad_argument} for measures that are not positive
[[nodiscard]] std::vector<SkinRegion> palmar_surface(const Hand& hand, const SkinOptions& options = {});

}  // namespace haptogram
