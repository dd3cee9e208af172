// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "haptogram/model/array.hpp"

namespace haptogram {

/// A transducer's directivity in a form that vector loops evaluate.
struct FittedPattern {
    enum class Kind { point, polynomial, table } kind = Kind::point;
    std::vector<float> values;  ///< coefficients in 2·cos²θ − 1, lowest power first; or amplitudes against angle
    bool behind = true;         ///< of a table: whether the back radiates as the front does
};

/// Degrees that polynomials come in, so that loops over them can be unrolled.
inline constexpr std::size_t polynomial_degrees[] = {5, 8, 14};

/// Fits the pattern to 2e-6 of the amplitude on the axis. Pistons many wavelengths wide become tables.
/// @param k  wave number, rad/m
[[nodiscard]] FittedPattern fit_pattern(const Transducer& transducer, double k);

}  // namespace haptogram
