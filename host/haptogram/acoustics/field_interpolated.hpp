// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>

#include "haptogram/acoustics/coarse.hpp"
#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"

// Fields on a coarse grid, interpolated from there, and how far off they are. Only the fields use it.

namespace haptogram {

/// The field on a coarse grid, and interpolated from there, in slabs of planes, one after the other, so that the coarse
/// grid takes little memory beside the result: a 32nd of it, or 2 MB. Neighbouring slabs both compute the coarse planes
/// that both need.
void interpolate_slabs(const Array& array, const FittedPattern& pattern, Drives drives, const CoarseGrid& coarse,
                       std::span<std::complex<float>> found, const FieldOptions& options);

/// How far a field on a grid is from the sum of the waves, as PressureField::error says: at the grid's corners and at
/// points all over it, whose fractions of its sides are multiples of irrational numbers.
[[nodiscard]] double deviation(const Array& array, const FittedPattern& pattern, Drives drives, const Grid& grid,
                               std::span<const std::complex<float>> found);

}  // namespace haptogram
