// SPDX-License-Identifier: Apache-2.0
// The loops that interpolate fields between the points of a coarse grid, with the processor's vector instructions.
#pragma once
#include <complex>
#include <cstddef>

#include "haptogram/acoustics/coarse.hpp"

namespace haptogram {

/// Computes rows of a field from the field on a coarse grid: those of one plane of constant z, from `begin` to before
/// `end`. Along x and y only the real parts of the weights are used.
/// @param coarse   field on grid.grid(), with room for interpolation_overrun further values that are read and not used
/// @param scratch  room for scratch_of_interpolation() floats, aligned as Highway allocates
/// @param out      the rows one behind the other, grid.x.size values each
void interpolate_rows(const CoarseGrid& grid, const std::complex<float>* coarse, std::size_t plane, std::size_t begin,
                      std::size_t end, float* scratch, std::complex<float>* out);
inline constexpr std::size_t interpolation_overrun = 64;

/// @param rows  how many are computed in one call at most
[[nodiscard]] std::size_t scratch_of_interpolation(const CoarseGrid& grid, std::size_t rows);

}  // namespace haptogram
