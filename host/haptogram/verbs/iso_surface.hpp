// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <string>
#include <vector>

#include "haptogram/verbs/field.hpp"

namespace haptogram {

/// Where a field over a volume has one value.
struct IsoSurface {
    double value = 0.0;
    /// Metres; counter-clockwise as seen from where the field is weaker.
    std::vector<std::array<Vec3, 3>> triangles;
    /// It ends at the volume's edge, or where the field is not known (NaN), and goes on there.
    bool leaves = false;
};

/// The surface of one value: each cell of the grid is cut into six tetrahedra (of the same kind in all cells, so that
/// neighbours fit), in which the field is taken as linear.
/// @param volume  of one part, and at least two points along each axis
/// @throws Error{bad_argument} for any other field
[[nodiscard]] IsoSurface iso_surface(const Field& volume, double value);

/// The surface at this many decibels below the greatest value of the volume. A radiation pressure goes with the square
/// of the sound pressure, so that all quantities have the same surface.
/// @throws Error{bad_argument} as iso_surface(), and when below_db is not above 0
[[nodiscard]] IsoSurface surface_below(const Field& volume, double below_db);

/// Binary STL, millimetres.
[[nodiscard]] std::string to_stl(const IsoSurface& surface);

/// In words, what it is.
[[nodiscard]] std::string description_of(const IsoSurface& surface);

}  // namespace haptogram
