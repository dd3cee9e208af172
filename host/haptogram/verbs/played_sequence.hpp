// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "haptogram/acoustics/drive_sequence.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/pulses.hpp"

namespace haptogram {

/// What an image plays in one pass of its sequence, each record as its pulses would be measured; where the board
/// modulates, in as many passes as make whole rounds of the modulation. It repeats.
/// @throws Error{bad_input} when those are too many
[[nodiscard]] DriveSequence sequence_of(const Bundle& bundle);

/// What was measured at the pins, one carrier period after the other from the first pulse on. A pulse belongs to the
/// period in which it rises. The sequence is the whole passes of the image after the first one, so that it repeats,
/// when at least two passes were measured; the first one begins in silence. Otherwise it is everything, and does not
/// repeat.
/// @param name  of the pulse file, for messages
/// @throws Error{bad_input} when there are no pulses, or a channel or an index is none of the manifest's
[[nodiscard]] DriveSequence sequence_of(const Manifest& manifest, const std::vector<Pulse>& pulses,
                                        const std::string& name);

/// What is asked for by each record's foci, one after the other, for their dwells: the places for speed and spacing.
/// Steps follow the sequence; a step of silence has no foci, and neighbours with the same places become one step.
[[nodiscard]] Path places_of(const Manifest& manifest, const DriveSequence& sequence);

}  // namespace haptogram
