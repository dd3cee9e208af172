// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <string>
#include <vector>

#include "haptogram/acoustics/field.hpp"

namespace haptogram {

/// What makes a sound field: sets of drives, each for its share of the time.
struct Excitation {
    Array array;
    std::vector<std::vector<std::complex<double>>> drives;  ///< one an element, Pa·m
    std::vector<double> weights;                            ///< of each set; only their ratios matter
    std::vector<Vec3> foci;                                 ///< that were asked for, metres
    std::string title;                                      ///< in words, for pictures

    /// The same in the form that the functions of acoustics/field.hpp take. It refers to this object, and is valid as
    /// long as this object is.
    [[nodiscard]] std::vector<WeightedDrives> sequence() const;
};

/// Multiplies every drive. With the root of a modulation's mean square, mean squares and radiation pressures become
/// those of the modulated sound.
void weaken(Excitation& excitation, double factor);

/// One focal point, exact phases, full strength.
/// @throws Error{bad_argument} when the array cannot reach it
[[nodiscard]] Excitation excitation_of(const Array& array, Vec3 focus);

/// One of the sets of drives, as if it played alone.
/// @param place  counted from 0
/// @throws Error{bad_argument} when there is no such set
[[nodiscard]] Excitation only(const Excitation& excitation, std::size_t place);

}  // namespace haptogram
