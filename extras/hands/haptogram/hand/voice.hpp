// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/hand/skin_line.hpp"
#include "haptogram/shape/draw.hpp"

namespace haptogram {

/// A part of what a focus does: the way from one place of the skin to another, or silence for as long.
struct Leg {
    SkinPoint from, to;
    double seconds = 0.0;
    bool silent = false;
    std::size_t line = 0;  ///< the number of the line that it is on
};

/// What one focus does, over and over. Several voices play at the same time.
struct Voice {
    std::vector<Leg> legs;
    double am_hz = 0.0;  ///< of its own amplitude, a sine from 0 to 1; 0: none
    [[nodiscard]] double seconds() const;
};

/// One focus that draws lines at a pace, in their order.
/// @throws Error{bad_argument} unless the pace has exactly one positive number
[[nodiscard]] Voice drawn(const std::vector<SkinLine>& lines, const Pace& pace, Jump jump);

/// What became of the voices when they were played.
struct Played {
    std::size_t foci = 0;          ///< that were asked for, one a step and voice
    std::size_t out_of_reach = 0;  ///< of these; they stay silent
    std::string why;               ///< the first of them is out of reach
    std::size_t lines_missed = 0;  ///< too short for the distance between steps, so that no focus is on them
};

/// Turns voices into a path. A focus is where its voice is in the middle of the step. What the array cannot reach is
/// silent.
class PathPen {
public:
    /// @param dwell  carrier periods of a step, at least 1
    /// @throws Error{bad_argument} for a dwell of 0
    PathPen(const Array& array, double carrier_hz, std::uint32_t dwell);

    /// Plays voices until a time. Each goes on at the share of its pass at which the last one of its number stopped.
    /// Steps are not cut, so the next voices begin up to a dwell late, and end in time all the same.
    /// @param until_s  since the path's beginning; voices may be empty: silence
    /// @param amplitude  of all foci
    Played play(const std::vector<Voice>& voices, double until_s, double amplitude = 1.0);

    /// Plays one pass of the first voice, in so many steps, or in steps as near to the dwell as fill it evenly. The
    /// others take as many whole passes as come nearest to their pace, and their modulation whole periods, so that the
    /// path can be repeated.
    /// @throws Error{bad_input} when a step would last less than a carrier period
    Played play_pass(const std::vector<Voice>& voices, std::optional<std::size_t> points = {});

    [[nodiscard]] Path path() const { return path_of(stretches_); }

private:
    void play_step(const std::vector<Focus>& foci, double periods);
    void add(std::vector<Focus>& foci, const Leg& leg, Vec3 position, double am_hz, double time_s,
             Played& played) const;

    const Array& array_;
    double carrier_hz_;
    std::uint32_t dwell_;
    double at_periods_ = 0.0;  ///< what has been played
    std::vector<double> shares_;
    std::vector<Stretch> stretches_;
};

}  // namespace haptogram
