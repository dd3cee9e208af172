// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "haptogram/array/rig.hpp"
#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {

/// The core of each of a rig's arrays, in their order: the one that the rig's file names, or else the array's own.
/// @param board  takes the place of all of them
[[nodiscard]] std::vector<Core> cores_of(const Rig& rig, const std::optional<std::string>& board = {});

/// A rig's boards and their ports, without images, for who makes what they play as it plays.
/// @throws Error{bad_input} for an array whose board is not known, or has fewer channels
[[nodiscard]] RigBundle boards_of(const Rig& rig);

/// A rig as one array, with the core of its units' boards, widened to all elements: each unit has a board of its own,
/// and all count the same ticks.
/// @throws Error{bad_input} for a file that cannot be used, or units whose boards differ in their clocks or timers
[[nodiscard]] ProjectInstrument instrument_of_rig(const std::string& name);

/// The images of a rig's boards, and what became of the shape on the way.
struct CompiledRig {
    Compiled whole;  ///< as one image of all elements
    RigBundle bundle;
};

/// Compiles a project for a rig: its path is made for all arrays together, in the rig's frame, and each board gets its
/// part of every record.
/// @param rig   a rig's file, or a shipped rig; the project names no array
/// @param name  of the rig manifest's file
/// @throws Error as compile(), and Error{bad_input} when the boards are not alike, cannot be kept in step, or cannot
/// begin in an agreed carrier period
[[nodiscard]] CompiledRig compile_rig(const Project& project, const std::string& rig, const std::string& name,
                                      const Progress& progress = {});

/// The same of a path, as compile() makes it into records.
[[nodiscard]] CompiledRig compile_rig(const Path& path, Method solver, const std::string& quantise,
                                      const std::string& rig, const std::string& name);

/// The same for images whose sequence is streamed, and so may be longer than the boards' memories.
[[nodiscard]] CompiledRig compile_rig_for_stream(const Project& project, const std::string& rig,
                                                 const std::string& name);

}  // namespace haptogram
