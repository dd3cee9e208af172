// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/verbs/focus_check.hpp"
#include "playback.hpp"

namespace haptogram::sim {

/// What the pulses of one record made of its focal points.
struct RecordResult {
    std::uint64_t cycles = 0;  ///< that it played; 0: not at all, and `check` says nothing
    FocusCheck check;
    FocusLimits limits;   ///< a focus is on target within these
    bool steady = false;  ///< played long enough that its own pulses could be told from its neighbours'
};

/// What a run of an image on the Verilated core showed.
struct Simulation {
    Playback playback;
    std::vector<RecordResult> records;
    std::size_t checked = 0, unsteady = 0;  ///< records
    std::vector<std::size_t> off;           ///< indices of records that missed their target
    double least_kept = 1.0, mean_kept = 0.0, worst_offset_m = 0.0;

    /// No contract was broken, and every focus is where it was asked.
    [[nodiscard]] bool good() const { return playback.violation_count == 0 && off.empty(); }
};

/// Plays an image on the Verilated core and checks, from the pulses measured at its pins, the contracts and every
/// focus.
/// @throws Error{bad_input} when the image would not play or no Verilated core can play it
[[nodiscard]] Simulation simulate(const Bundle& bundle, const PlaybackOptions& options);

/// Checks every focus of an image from the pulses that a playback has measured.
[[nodiscard]] Simulation judged(const Bundle& bundle, Playback playback, const Progress& progress = {});

/// Verilator's trace writer does not notice when the disk is full. This function does.
/// @param name  of the file that the user asked for, for messages
/// @throws Error{bad_input} when the FST file is cut short
void require_whole_trace(const std::filesystem::path& file, const std::string& name);

}  // namespace haptogram::sim
