// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/acoustics/grid.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/model/array.hpp"

namespace haptogram {

/// Complex source strengths, one an element, Pa·m.
using Drives = std::span<const std::complex<double>>;

/// Drives that play for a share of the time.
struct WeightedDrives {
    double weight = 1.0;  ///< only the ratios of the weights matter
    Drives drives;
};

struct FieldOptions {
    /// How many threads may work on this call; 0: one a processor, and never more than that. Calls that run at the same
    /// time do not affect each other's number. The result is the same, byte by byte, for any number.
    unsigned threads = 1;
    Progress progress{};  ///< told from the calling thread; when it ends the work, the call throws Error{cancelled}
};

/// Complex pressure in Pa, convention e^{jωt}: the sum over the elements of drive · propagation (propagation.hpp), each
/// element radiating around its own normal. Computed in single precision; the error is at most 1e-4 of the largest |p|
/// that the drives, with any phases, could make at any of the points asked.
/// @throws Error{bad_input} when a point coincides with an element, or there is not one drive an element
[[nodiscard]] std::vector<std::complex<float>> pressure_at(const Array& array, Drives drives,
                                                           std::span<const Vec3> points,
                                                           const FieldOptions& options = {});
/// The same on a grid, in the order of Grid::point(). Much faster where the grid's steps divide the pitch of an array
/// that is a grid itself (shift.hpp).
[[nodiscard]] std::vector<std::complex<float>> pressure_on(const Array& array, Drives drives, const Grid& grid,
                                                           const FieldOptions& options = {});

/// Mean square of the pressure over a sequence of drives, Pa²: Σ weight·|p|²/2 over Σ weight, at any points or on a
/// grid. Zero when nothing plays. Errors as above.
[[nodiscard]] std::vector<float> mean_square_pressure_at(const Array& array, std::span<const WeightedDrives> sequence,
                                                         std::span<const Vec3> points,
                                                         const FieldOptions& options = {});
[[nodiscard]] std::vector<float> mean_square_pressure(const Array& array, std::span<const WeightedDrives> sequence,
                                                      const Grid& grid, const FieldOptions& options = {});

}  // namespace haptogram
