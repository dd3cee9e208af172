// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"

namespace haptogram {

/// An array in its place.
struct PosedArray {
    Array array;
    Pose pose;
};

/// What drives one array of a rig, and where it is plugged in; both as the rig's file names them.
struct RigBoard {
    std::string board{};  ///< empty: the board that the array's own file names
    std::string port{};   ///< empty: the caller that plays the rig names it
};

/// Several arrays that play together. Their elements are numbered through: first those of the first array, then those
/// of the second.
struct Rig {
    std::string name;
    std::vector<PosedArray> arrays;
    std::string file{};              ///< where it was read from, for messages
    std::vector<RigBoard> boards{};  ///< one an array, or none at all
};

/// All of a rig's elements as one array in the rig's frame, for everything that computes with elements. A focal point
/// is within its reach that is within that of at least one of the arrays, and far enough from the elements of all.
/// @throws Error{bad_argument} when the rig is empty, or its arrays differ in carrier, duty, air, transducer or reach
[[nodiscard]] Array joined(const Rig& rig);

/// Reads a rig file (TOML); host/arrays/README.md describes its keys.
/// @throws Error{bad_input} naming the file, the line and the key, also for unknown keys, for arrays that cannot play
/// together, and for units that stand in each other
[[nodiscard]] Rig load_rig(const std::filesystem::path& path);

/// Finds `name` as a path, or among the shipped rigs.
[[nodiscard]] Rig find_rig(const std::string& name);
[[nodiscard]] std::vector<std::string> shipped_rigs();

/// The array in the coordinates of a pose: what its elements look like from there. A plane that lies obliquely to the
/// array is an even plane in the coordinates of its own pose, and so is the array's field on it.
[[nodiscard]] Array seen_from(Array array, const Pose& pose);

}  // namespace haptogram
