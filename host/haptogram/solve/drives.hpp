// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/solve/solver.hpp"

namespace haptogram {

/// Drives that make several foci at the same time, one drive an element, 1 at full strength. An element's drive is a
/// superposition: the sum, over the foci, of the phase that the element would have for that focus alone, times the
/// amplitude of the focus. All drives are then scaled so that the strongest has the largest of the foci's amplitudes.
/// For one focus this is the focal law (Haptogram eq. 2-5): each element at full strength, delayed by (R_max − R)/c.
/// @throws Error{bad_input} when a focus is not finite
[[nodiscard]] std::vector<std::complex<double>> superposed_drives(const Array& array, std::span<const Focus> foci);

/// The record whose pulses come nearest to the drives: each channel starts at its drive's phase, rounded to the nearest
/// tick. All channels of a record have pulses of one length, so of the drives' amplitudes only the largest is kept;
/// an element without drive is silent, and so are the channels beyond the elements.
/// @param drives  one an element, 0…1
[[nodiscard]] Record quantise(std::span<const std::complex<double>> drives, const Timer& timer, std::uint32_t channels);

/// The record of each step: of several foci as quantise(solve(…)) makes it, by phases alone, and of a single focus by
/// the focal law. A record's amplitude is the largest of its foci's times the step's factor in `amplitudes`.
[[nodiscard]] std::vector<Record> records_of(const Array& array, const Timer& timer, std::uint32_t channels,
                                             std::span<const PathStep> steps, std::span<const double> amplitudes,
                                             Method method = Method::gauss_newton);

}  // namespace haptogram
