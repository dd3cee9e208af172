// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/pulses.hpp"
#include "haptogram/solve/segments.hpp"

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

/// The same as a device makes it whose pulses lie on segments of the carrier period.
[[nodiscard]] Excitation in_segments(const Excitation& excitation, const Segments& segments);

/// An image: each record as its pulses would be measured, for the time that it plays in one pass, weakened by the root
/// of the mean square of its modulation. Silence in the sequence is a set of its own behind the records'.
/// @param record  only this one, counted from 1, whatever its kind; 0: all
/// @throws Error{bad_argument} when there is no such record
[[nodiscard]] Excitation excitation_of(const Bundle& bundle, std::uint32_t record = 0);

/// One of the sets of drives, as if it played alone.
/// @param place  counted from 0
/// @throws Error{bad_argument} when there is no such set
[[nodiscard]] Excitation only(const Excitation& excitation, std::size_t place);

/// What a manifest asks for: exact phases for each record's foci, each for the share of its dwell.
[[nodiscard]] Excitation excitation_of(const Manifest& manifest, const std::string& name, std::uint32_t record = 0);

/// What was measured at the pins while the manifest's image played. Each record's drives have the root of the mean of
/// its pulses' squares, and periods without pulses, of a modulation or of the sequence, are a set of silence behind
/// them.
/// @param name  of the pulse file, for messages
[[nodiscard]] Excitation excitation_of(const Manifest& manifest, const std::vector<Pulse>& pulses,
                                       const std::string& name);

}  // namespace haptogram
