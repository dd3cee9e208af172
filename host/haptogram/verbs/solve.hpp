// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/format/image.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/solve/solver.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {

/// One set of foci, and what makes it.
struct SolvedStep {
    std::vector<Focus> foci;
    std::vector<std::complex<double>> drives;  ///< one an element, 1 at full strength
    Record record;                             ///< the drives' phases in ticks, all pulses of one length
    Quality exact;                             ///< of the drives
    Quality quantised;  ///< of the record; with `quantise`, of that device's pulses, which may differ in length
};

/// Sets of foci, one after the other.
struct Solved {
    Array array;
    Core core;
    std::string rig;  ///< that the array is of; empty: it is one array
    Timer timer;
    SolveOptions options;
    bool follow = false;   ///< each set began with the drives of the one before
    std::string quantise;  ///< device on whose segments the pulses lie, as segments_of() knows it; empty: none
    std::vector<SolvedStep> steps;
};

/// Foci as text: a line "x,y,z" or "x,y,z,amplitude" each, in millimetres and 0…1. An empty line ends a set of foci.
/// What follows a # is a comment.
/// @param where  names the text in messages
/// @throws Error{bad_input} naming the line
[[nodiscard]] std::vector<std::vector<Focus>> foci_from_text(std::string_view text, const std::string& where);
/// One such line. @param setting  names it in messages
/// @throws Error{bad_argument}
[[nodiscard]] Focus parse_focus_mm(const std::string& setting, const std::string& line);

/// Solves each set.
/// @param follow  begin each set with the drives of the one before, for foci that move by a small part of a wavelength;
///                the first set has none before it, and takes as many rounds as by default
/// @param device  on whose segments the pulses shall lie, as segments_of() knows it; empty: none
/// @throws Error as solve() and choose_timer(), naming the set, and Error{bad_input} for foci out of the array's reach
[[nodiscard]] Solved solve_steps(const std::vector<std::vector<Focus>>& steps, const Array& array, const Core& core,
                                 const SolveOptions& options, bool follow, const Progress& progress = {},
                                 const std::string& device = {});

/// All of it as JSON text: millimetres, Pa, and drives as amplitude and phase in radians.
[[nodiscard]] std::string to_json_text(const Solved& solved);
/// Drives as CSV: step,element,amplitude,phase_rad,tick; counted from 1.
[[nodiscard]] std::string to_csv(const Solved& solved);

/// @throws Error{bad_argument} when a path's ending is none of .csv, .json, .png and .hex
void check_solved_path(const std::string& path);
/// Writes it in the format that the path's ending names; standard output ("-") gets CSV. An image (.hex) plays the sets
/// at `rate_hz`, and its manifest is written beside it; of a rig, its manifest and the images of its boards. It is made
/// by compile() with the same solver. The picture shows the pressure around the first set of foci, and how even the
/// foci of all sets are; it is drawn by python3 with matplotlib.
/// @throws Error{bad_input} when it cannot be written, Error{bad_argument} for an image of drives that compile() does
/// not make: with amplitudes, another level or number of rounds, or each from the last; and as even_dwells() and
/// compile()
void write_solved(const std::string& path, const Solved& solved, double rate_hz = 10.0);

}  // namespace haptogram
