// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "haptogram/base/progress.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/verbs/path_makers.hpp"
#include "haptogram/verbs/timeline.hpp"

namespace haptogram {

/// What a verb works on, as a user names it. Exactly one of `file`, `focus` and `pulses` is given.
///
/// A file is known by its name's ending and, where that is not enough, by its content:
/// - an image (.hex or any other ending), with its manifest beside it
/// - a rig's manifest (.json): its images together
/// - what is compiled first: a project (.toml); a path (.json, .csv with times, .adaptics) or a shape (.ply, .obj,
/// .stl,
///   .xyz, .csv without times), with every other setting at its default
/// - the manifest of an image alone (.json): exact phases for its foci
struct Source {
    std::string file;
    std::uint32_t record = 0;                 ///< only this record of it; 0: all in turn
    std::optional<Vec3> focus;                ///< or exact phases for a point, metres
    std::optional<std::string> array, board;  ///< of a focus, a path or a shape: by default tile-10x10 and its board;
                                              ///< what has its own must be for them
    std::string rig;                          ///< of `focus` instead of the array: several in their places
    std::string quantise;                     ///< device on whose segments the drives of `focus` lie; empty: exact
    std::string pulses;                       ///< or pulses that a simulation measured, and
    std::string manifest;  ///< the manifest of the image, or the rig's images, that was played; of an
                           ///< image, its manifest if it is not the one beside it
    PathMakers makers{};   ///< for what is compiled first
};

/// Whether a file, by its name's ending, is one that open_timeline() takes, and not rows of foci.
[[nodiscard]] bool is_source_file(const std::string& file);
/// Whether a file is a path, by its name's ending and, where that is not enough, by its content.
[[nodiscard]] bool is_path_file(const std::string& file);
/// Whether a file is the manifest of a rig's images.
[[nodiscard]] bool is_rig_file(const std::string& file);

/// What a file makes a board play, with its manifest; of a rig, its images as one.
/// @throws Error{bad_argument} for a source that has no image; Error{bad_input} for a file that cannot be used
[[nodiscard]] Bundle open_bundle(const Source& source, const Progress& progress = {});

/// The bytes of the Intel HEX image that a file is, or is compiled to, for verbs that need no manifest.
[[nodiscard]] std::string open_hex(const std::string& file, const PathMakers& makers = {},
                                   const Progress& progress = {});

/// The rate of the board that a project, or an image with its manifest beside it, is for.
[[nodiscard]] std::optional<std::uint32_t> likely_rate(const std::string& file);

/// @throws Error{bad_argument} when nothing or more than one thing is named; Error{bad_input} for files that cannot be
/// used, and for an array or a board that they are not for
[[nodiscard]] Timeline open_timeline(const Source& source, const Progress& progress = {});

/// Reads "x,y,z" in millimetres. @param setting  names it in messages
[[nodiscard]] Vec3 parse_point_mm(const std::string& setting, const std::string& text);

/// The same of three numbers in another unit, as they are.
[[nodiscard]] Vec3 parse_three(const std::string& setting, const std::string& text, std::string_view unit);

}  // namespace haptogram
