// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "haptogram/array/array.hpp"

namespace haptogram {

/// A transducer's directivity in a form that is fast to compute with vector instructions.
struct FittedPattern {
    enum class Kind { point, polynomial, table } kind = Kind::point;
    /// Of a polynomial: coefficients of the powers of 2·cos²θ − 1, lowest first. Of a table: amplitudes at evenly
    /// spaced angles from 0 to 90°.
    std::vector<float> values;
    bool behind = true;  ///< an element radiates backwards as it does forwards; otherwise not at all
    double error = 0.0;  ///< largest difference from a measured pattern, of the amplitude on the axis
};

/// The degrees that a polynomial may have. There are few, so that the loops can be unrolled for each of them.
inline constexpr std::size_t polynomial_degrees[] = {5, 8, 14};

/// Fits the pattern with an error of at most 2e-6 of the amplitude on the axis. Pistons that are many wavelengths wide
/// become tables. A measured pattern stays a table, unless a polynomial of degree 5 or 8 differs from the table's
/// straight lines by at most `measured_error`: a table that is measured to 1 dB at its ends is fitted to 0.1 dB by
/// degree 5.
/// @param k               wave number, rad/m
/// @param measured_error  of the amplitude on the axis
[[nodiscard]] FittedPattern fit_pattern(const Transducer& transducer, double k, double measured_error = 0.0);

}  // namespace haptogram
