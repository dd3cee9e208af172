// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/model/array.hpp"
#include "haptogram/render/path.hpp"
#include "haptogram/solve/record.hpp"
#include "haptogram/solve/timer.hpp"

namespace haptogram {

/// Drives whose waves add up at each of several foci, one an element, 1 at full strength: the sum over the foci of the
/// phases that focus on each alone, times its amplitude (superposition), scaled so that the strongest element has the
/// largest of the amplitudes. For one focus this is the focal law (Haptogram eq. 2-5): full strength, delayed by
/// (R_max − R)/c.
/// @throws Error{bad_input} when a focus is not finite
[[nodiscard]] std::vector<std::complex<double>> superposed_drives(const Array& array, std::span<const Focus> foci);

/// Ticks of a pulse that makes so much of the carrier's full amplitude: (cycle/π)·asin(a·sin(π·duty)) (Hoshi eq. 7
/// solved for the pulse), rounded; 0 for 0, the timer's own pulse for 1.
[[nodiscard]] std::uint32_t pulse_ticks(const Timer& timer, double amplitude);

/// The record whose pulses come nearest to the drives: each channel starts at its drive's phase, rounded to the nearest
/// tick. All channels of a record have pulses of one length, so of the drives' amplitudes only the largest is kept;
/// an element without drive is silent, and so are the channels beyond the elements.
/// @param drives  one an element, 0…1
[[nodiscard]] Record quantise(std::span<const std::complex<double>> drives, const Timer& timer, std::uint32_t channels);

/// The record of a path's step times a factor, as quantise(superposed_drives(…)) would make it; a single focus takes
/// the faster focal law. Its amplitude is the largest of its foci's times the factor.
[[nodiscard]] std::vector<Record> records_of(const Array& array, const Timer& timer, std::uint32_t channels,
                                             std::span<const PathStep> steps, std::span<const double> amplitudes);

}  // namespace haptogram
