// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <optional>
#include <span>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/shift.hpp"

// Fields as sums of the elements' waves: each wave at each point, or on a grid that has the array's pitch one wave,
// shifted. Only the fields use it.

namespace haptogram {

/// What the steps of a method take, in vector instructions a point. They need not be exact: they only choose.
namespace cost {
constexpr double wave = 45.0;           ///< one element's wave
constexpr double share = 4.0;           ///< one shifted copy
constexpr double interpolation = 70.0;  ///< along x and y
}  // namespace cost

/// Sums on a grid, and what they take: by shifts if array and grid have any and these take less than summing
/// every wave.
struct PlannedSums {
    std::optional<ShiftedGrid> shifted;
    double cost = 0.0;
};

/// The cheaper of both. A lattice of shifts must fit into memory. A plane within 1 mm of the elements goes to the
/// direct sum, which computes points near an element in double precision.
[[nodiscard]] PlannedSums plan_sums(const Array& array, const Grid& grid);

/// Sums every element's wave at every point.
void add_directly(const Array& array, const FittedPattern& pattern, Drives drives, std::span<const Vec3> points,
                  std::span<std::complex<float>> found, const FieldOptions& options);
/// The pressure on a grid, by the sums that were planned for it.
void add_sums(const Array& array, const FittedPattern& pattern, Drives drives, const Grid& grid,
              const PlannedSums& sums, std::span<std::complex<float>> found, const FieldOptions& options);

/// What sums of waves in single precision are held to (tests/unit/test_kernel.cpp). Coordinates are rounded relative to
/// the blocks of points, so points that are spread over metres are less exact.
[[nodiscard]] double error_of_sums(const Grid& grid);

}  // namespace haptogram
