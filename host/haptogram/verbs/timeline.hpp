// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/pulses.hpp"
#include "haptogram/verbs/focus_analysis.hpp"

namespace haptogram {

/// What plays, whatever a user named it by (source.hpp): the records of one array, what each means, and what drives
/// them: an image, or pulses that were measured while it played, or, without both, exact phases.
struct Timeline {
    Manifest manifest;           ///< array, board and timer, and what each record is to make
    std::optional<Image> image;  ///< as the board plays it
    std::vector<Pulse> pulses;   ///< as they were measured at the pins
    std::string segments;        ///< device on whose segments exact phases are put (segments_of()); empty: none
    std::string name;            ///< of the file, for messages
    std::string title;           ///< in words, for pictures
};

/// What a board plays.
[[nodiscard]] Timeline timeline_of(const Bundle& bundle);
/// Exact phases for what a manifest asks for.
[[nodiscard]] Timeline timeline_of(Manifest manifest, const std::string& name);
/// What was measured at the pins while the manifest's image played.
/// @throws Error{bad_input} when there are no pulses, or a channel or an index is none of the manifest's
[[nodiscard]] Timeline timeline_of(Manifest manifest, std::vector<Pulse> pulses, const std::string& name);
/// Exact phases for one focal point on an array whose board is this one.
[[nodiscard]] Timeline timeline_of(const Array& array, const Core& core, Vec3 focus);

/// Foci that play at the same time, and what drives the elements while they do.
struct FocusDrives {
    std::uint32_t record = 0;   ///< index of the first record that makes them
    std::vector<Focus> foci;    ///< the strongest has amplitude 1; none of amplitude 0
    std::uint64_t periods = 0;  ///< of the carrier, in a pass or in all that was measured, with the silences of
                                ///< their modulation
    std::vector<std::complex<double>> drives;  ///< one an element, Pa·m: the root of the mean of the squares over that
                                               ///< time, with the phases of the strongest record; empty when nothing
                                               ///< was measured
};

/// Each set of foci once, in the order of its first record. Records whose foci differ by a common factor alone are a
/// modulation of one, and so is silence between two of them.
[[nodiscard]] std::vector<FocusDrives> foci_of(const Timeline& timeline);

/// What plays as sets of drives, a record each, for its share of the time. Silence, of the sequence or of a modulation
/// that was measured, is a set behind the records'.
/// @param record  only this one, counted from 1, whatever its kind; 0: all
/// @throws Error{bad_argument} when there is no such record, or no pulse of it
[[nodiscard]] Excitation excitation_of(const Timeline& timeline, std::uint32_t record = 0);

/// What plays in one pass, each record as its pulses are; where the board modulates, in as many passes as make whole
/// rounds of the modulation. It repeats. Of measured pulses, the whole passes after the first one, which begins in
/// silence, when at least two were measured; otherwise everything, which then does not repeat. A pulse belongs to the
/// carrier period in which it rises.
/// @throws Error{bad_input} when those are too many periods
[[nodiscard]] DriveSequence sequence_of(const Timeline& timeline);

/// What is asked for by each record's foci, one after the other, for their dwells: the places for speed and spacing.
/// Steps follow the sequence; a step of silence has no foci, the strongest focus of any other has amplitude 1, and
/// neighbours with the same foci become one step.
[[nodiscard]] Path places_of(const Manifest& manifest, const DriveSequence& sequence);
/// The same in the order of the records, each for its dwell in a pass, without regard to what was measured or to a
/// modulation.
[[nodiscard]] Path places_of(const Timeline& timeline);

}  // namespace haptogram
