// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/acoustics/grid.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/model/array.hpp"

namespace haptogram {

using Drives = std::span<const std::complex<double>>;  ///< one an element, Pa·m

/// Drives that play for a share of the time.
struct WeightedDrives {
    double weight = 1.0;
    Drives drives;
};

struct FieldOptions {
    unsigned threads = 1;  ///< the result is the same, byte by byte, for any number
    Progress progress{};
};

/// Complex pressure in Pa, convention e^{jωt}: Σ drives·propagation (field.hpp), in single precision, off by at most
/// 1e-4 of the largest |p| that the drives can make at the nearest point asked.
/// @throws Error{bad_input} when a point coincides with an element
[[nodiscard]] std::vector<std::complex<float>> pressure_at(const Array& array, Drives drives,
                                                           std::span<const Vec3> points,
                                                           const FieldOptions& options = {});
[[nodiscard]] std::vector<std::complex<float>> pressure_on(const Array& array, Drives drives, const Grid& grid,
                                                           const FieldOptions& options = {});

/// Σ weight·|p|²/2 over Σ weight: the mean square of the pressure in Pa² over a sequence of drives.
[[nodiscard]] std::vector<float> mean_square_pressure(const Array& array, std::span<const WeightedDrives> sequence,
                                                      const Grid& grid, const FieldOptions& options = {});

}  // namespace haptogram
