// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <vector>

#include "haptogram/format/bundle.hpp"
#include "haptogram/format/pulses.hpp"

namespace haptogram {

/// What the transducers were driven with while one record played.
struct MeasuredRecord {
    std::uint64_t cycles = 0;                            ///< carrier periods that it played
    std::vector<std::complex<double>> drives;            ///< one an element, Pa·m; the 40 kHz component of its pulses
    std::vector<std::complex<double>> root_mean_square;  ///< the same phases, with the root of the mean of the pulses'
                                                         ///< squares, which differ where the board modulates
};

/// The place among the manifest's records of the one that a pulse is of.
/// @param where  names the pulses' file
/// @throws Error{bad_input} when there is none
[[nodiscard]] std::size_t place_of(const Manifest& manifest, const Pulse& pulse, const std::string& where);

/// Turns measured pulses into each record's drives. Where a record played for at least three periods in a row, each
/// channel's first and last pulse of that stretch are left out: pulses of neighbouring records may have merged with
/// them.
/// @return one entry a record, in the order of the manifest; `cycles` is 0 when it did not play
/// @throws Error{bad_input} when a pulse's channel or index is none of the manifest's
[[nodiscard]] std::vector<MeasuredRecord> measure(const Manifest& manifest, const std::vector<Pulse>& pulses,
                                                  const std::string& where);

/// The drives that a record's timings ask for, one an element, Pa·m, as its pulses would be measured.
[[nodiscard]] std::vector<std::complex<double>> drives_of(const Manifest& manifest, const Record& record);
/// The same of the record at a place of an image, of whatever kind (image.hpp), under one sample of the board's
/// modulation; 255 is none. Of foci, what the board computes.
[[nodiscard]] std::vector<std::complex<double>> drives_of(const Manifest& manifest, const Image& image,
                                                          std::size_t place, std::uint8_t sample = 255);

}  // namespace haptogram
