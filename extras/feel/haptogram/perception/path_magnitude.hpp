// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <map>
#include <string_view>

#include "haptogram/format/path.hpp"
#include "haptogram/perception/setting.hpp"
#include "haptogram/verbs/path_makers.hpp"

namespace haptogram::perception {

/// The modulation's part of Wanted, from its text as format/waveform.hpp reads it: one waveform with its frequency, and
/// the duty of a square wave.
/// @throws Error{bad_argument} naming "magnitude" for what no magnitude is known of: a text that is empty or static,
/// several waveforms, files, and radiation as the law of the waveform's values
[[nodiscard]] Wanted wanted_of(double magnitude, std::string_view am, bool values_are_radiation);

/// Lets every focus of a path feel with one magnitude while it is there: multiplies its amplitude by the command of its
/// place (setting_for() on the array).
/// @throws Error{bad_argument} naming "magnitude" and the place, when the array is too weak there, or when foci exist
/// at the same time and so share the array's pressure
PathMagnitude give_magnitude(Path& path, const Tables& tables, const Wanted& wanted, const Array& array);

/// Commands for one magnitude at any place of an array, for a renderer that meets new places in every frame. A focus'
/// force changes slowly from place to place. It is computed at the corners of a lattice, each when it is first needed,
/// and is linear in between; the command is then within 0.2 % of setting_for()'s above half an array's width.
class CommandLattice {
public:
    /// Keeps references to the tables and the array.
    /// @throws Error{bad_argument} when nothing feels so, wherever it is: see setting_for()
    CommandLattice(const Tables& tables, const Wanted& wanted, const Array& array);

    /// The command, 0…1. @throws Error as give_magnitude()
    [[nodiscard]] double at(Vec3 place);
    [[nodiscard]] std::size_t corners() const { return forces_.size(); }  ///< that were computed

private:
    [[nodiscard]] double force_at(const std::array<long, 3>& corner);

    const Tables& tables_;
    Wanted wanted_;
    const Array& array_;
    double needed_gf_;
    std::map<std::array<long, 3>, double> forces_;  ///< N, NaN out of the array's reach
};
/// The same for a path that is played in pieces.
PathMagnitude give_magnitude(Path& path, CommandLattice& commands);

/// The same with a project's magnitude and waveform, by the shipped tables, as PathMakers has it.
/// @throws Error as wanted_of() and give_magnitude()
PathMagnitude give_magnitude(Path& path, const Project& project, const Array& array);

}  // namespace haptogram::perception
