// SPDX-License-Identifier: Apache-2.0
// Opens what a rendering is of: a recording of hands, and the object that they feel.
#pragma once
#include <string>

#include "haptogram/hand/object.hpp"
#include "haptogram/hand/pose_file.hpp"
#include "haptogram/shape/shape.hpp"
#include "haptogram/verbs/hand_source.hpp"

namespace haptogram {

/// The object as its source says.
/// @param read  gets a mesh file's content; by default read_file()
/// @throws Error{bad_input} for files that cannot be used or have no volume, Error{bad_argument} for measures
[[nodiscard]] TouchObject open_object(const ObjectSource& source, const FileReader& read = {});

/// The surface of an object for a view: the file's mesh at its place, or, of a built-in one, where its distance is 0 on
/// a grid of 48 cells along its longest side, so that edges are drawn a little blunt. A half-space is drawn in its box.
/// @throws as open_object()
[[nodiscard]] Mesh surface_of(const ObjectSource& source, const FileReader& read = {});

/// A recording as a user names it: a file as load_hands() reads it, or "synthetic:SCRIPT" or "synthetic:SCRIPT:HEIGHT"
/// with the height of the palm in mm, which is one round of the script at 100 frames a second. Behind a file's name may
/// stand that of the tracker's mounting (hand/mounting.hpp), hands.json@desk.toml.
/// @param read  gets a file's content; by default read_file()
/// @throws Error{bad_input} or Error{bad_argument}
[[nodiscard]] HandRecording open_hands(const std::string& name, const std::string& model = {}, double rate_hz = 60.0,
                                       const FileReader& read = {});

}  // namespace haptogram
