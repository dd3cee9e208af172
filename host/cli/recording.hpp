// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/verbs/calibration_code.hpp"

namespace haptogram::cli {

/// Reads a recording: a sound file with one channel, as libsndfile knows it (.wav, .flac, …), or an oscilloscope's CSV:
/// lines of time in seconds and voltage, at even times, after any lines that begin with no number.
/// @throws Error{bad_input} naming the file, and the line
[[nodiscard]] Recording read_recording(const std::string& file);

/// The readings of a meter: CSV with the header `index,reading`, and a line for each record, in any order; nothing when
/// the file is none.
/// @throws Error{bad_input} naming the line
[[nodiscard]] std::optional<std::vector<double>> read_steps(const std::string& file);

}  // namespace haptogram::cli
