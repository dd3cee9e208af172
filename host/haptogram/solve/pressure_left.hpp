// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"

namespace haptogram {

/// What the transducers' bandwidth and the waves' different ways leave of the pressure of each step of a path that
/// repeats: the largest pressure at the step's foci while its waves arrive, over that of the step alone for ever. A
/// transducer's carrier follows its drive as a resonance of bandwidth B does, with the time constant 1/(πB), and an
/// element's wave arrives R/c later. Near foci leave more than far ones, because the drives differ less.
/// For two foci in turn, the resonators of acoustics/transient.hpp give the same within 0.03 when each lasts 12 carrier
/// periods, 0.04 for 8 and 0.07 for 4.
/// @return a fraction a step; 1 for silence. It exceeds 1 when the step before was stronger, or helps
/// @throws Error{bad_argument} for an unsound path
[[nodiscard]] std::vector<double> pressure_left(const Array& array, const Path& path);

/// The least of the fractions over the steps that are not silence, and their mean over time.
struct PressureLeft {
    double least = 1.0, mean = 1.0;
};
[[nodiscard]] PressureLeft summary_of(const Path& path, const std::vector<double>& left);

}  // namespace haptogram
