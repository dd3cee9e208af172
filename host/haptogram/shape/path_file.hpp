// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

#include "haptogram/format/path.hpp"

namespace haptogram {

// Files of paths. README.md beside this file describes the formats. In all of them an amplitude, or an intensity, is a
// fraction of the largest pressure, 0 to 1.

/// A path as JSON, format "haptogram-path-1": what path_from_json() reads back, the same in every bit.
/// @param carrier_hz  in whose periods the path counts
[[nodiscard]] std::string to_json_text(const Path& path, double carrier_hz);

/// @param where       names the file in messages
/// @param carrier_hz  of the board that is to play the path
/// @throws Error{bad_input} for invalid JSON, for unknown, missing or mistyped members, which it names, and when the
/// path counts in periods of a carrier that is more than 0.1 % off
[[nodiscard]] Path path_from_json(std::string_view text, const std::string& where, double carrier_hz);

/// Rows of a time, a position and an intensity. The first row names the columns: time_s or time_ms, x_mm, y_mm, z_mm,
/// and, if the intensity is not always 1, intensity. A focus lasts until the next row's time, rounded to whole carrier
/// periods as path_of() does; the last one lasts as long as the one before it. An intensity of 0 is silence.
/// @throws Error{bad_input} naming the line, also for times that do not rise by at least a carrier period
[[nodiscard]] Path path_from_csv(std::string_view text, const std::string& where, double carrier_hz);

/// Whether a file's text is that of a path, rather than of another kind of file with this ending: a JSON text that says
/// so, and a CSV text whose first row names a time, or "t".
[[nodiscard]] bool is_path_json(std::string_view text);
[[nodiscard]] bool is_path_csv(std::string_view text);

/// A path file's path; the name's ending tells the format: .json or .csv. Who reads AdapTics patterns, too, has
/// adaptics.hpp.
/// @throws Error{bad_input} also for another ending
[[nodiscard]] Path path_of_file(std::string_view text, const std::string& name, double carrier_hz);

}  // namespace haptogram
