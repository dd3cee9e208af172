// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

#include "haptogram/perception/setting.hpp"
#include "haptogram/render/path.hpp"

namespace haptogram::perception {

/// The modulation's part of Wanted, from its text as render/waveform.hpp reads it: one waveform with its frequency, and
/// the duty of a square wave.
/// @throws Error{bad_argument} naming "magnitude" for what no magnitude is known of: a text that is empty or static,
/// several waveforms, files, and radiation as the law of the waveform's values
[[nodiscard]] Wanted wanted_of(double magnitude, std::string_view am, bool values_are_radiation);

/// The commands that a path got, each a factor on the amplitude of its foci.
struct PathMagnitude {
    double least_command = 0.0, most_command = 0.0;
    bool moves = false;  ///< the path has several places; the tables are of a focus that rests
};

/// Lets every focus of a path feel with one magnitude while it is there: multiplies its amplitude by the command of its
/// place (setting_for() on the array).
/// @throws Error{bad_argument} naming "magnitude" and the place, when the array is too weak there, or when foci exist
/// at the same time and so share the array's pressure
PathMagnitude give_magnitude(Path& path, const Tables& tables, const Wanted& wanted, const Array& array);

}  // namespace haptogram::perception
