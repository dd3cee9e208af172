// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "haptogram/model/array.hpp"

namespace haptogram {

/// A transducer's directivity in a form that is fast to compute with vector instructions.
struct FittedPattern {
    enum class Kind { point, polynomial, table } kind = Kind::point;
    /// Of a polynomial: coefficients of the powers of 2·cos²θ − 1, lowest first. Of a table: amplitudes at evenly
    /// spaced angles from 0 to 90°.
    std::vector<float> values;
    bool behind = true;  ///< of a table: an element radiates backwards as it does forwards; otherwise not at all
};

/// The degrees that a polynomial may have. There are few, so that the loops can be unrolled for each of them.
inline constexpr std::size_t polynomial_degrees[] = {5, 8, 14};

/// Fits the pattern with an error of at most 2e-6 of the amplitude on the axis. Pistons that are many wavelengths wide
/// become tables.
/// @param k  wave number, rad/m
[[nodiscard]] FittedPattern fit_pattern(const Transducer& transducer, double k);

}  // namespace haptogram
