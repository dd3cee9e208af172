// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/pulses.hpp"

namespace haptogram {

/// A square modulation, as bursts of pulses at the pins show it.
struct Envelope {
    std::size_t bursts = 0;     ///< with silence before them
    double frequency_hz = 0.0;  ///< from the first of these to the last; 0 when there are not two
};

/// Finds the bursts of the channel that has the most pulses. Between two pulses of a burst there is one carrier period,
/// give or take half of one, by which a change of record may move a pulse.
/// @param pulses         in the order of time in each channel, as PulseRecorder has them
/// @param cycle_clocks   of the carrier
/// @param silent_before  whether the pins were silent before the first pulse because nothing played yet, so that the
/// first burst may be the rest of a longer one, and is not counted
[[nodiscard]] Envelope envelope_of(std::span<const Pulse> pulses, double clock_hz, std::uint64_t cycle_clocks,
                                   bool silent_before = true);

/// The pressure amplitude that drives make at a focus, over that of exact phases at full drive: 0…1.
/// @param drives  one an element, Pa·m, as measure() has them
[[nodiscard]] double share_of_full_drive(const Array& array, std::span<const std::complex<double>> drives, Vec3 focus);

}  // namespace haptogram
