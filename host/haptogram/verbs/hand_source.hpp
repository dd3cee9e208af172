// SPDX-License-Identifier: Apache-2.0
// What a rendering is of, as a user names it: a recording of hands, and the object that they feel.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/hand/object.hpp"
#include "haptogram/hand/pose_file.hpp"
#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// An object as a user names it.
struct ObjectSource {
    std::string name = "sphere";     ///< a kind of object_kinds(), or a mesh file
    std::optional<double> size_m;    ///< by default 100 mm, and a mesh as it is
    std::optional<double> height_m;  ///< of a cone, a pyramid and a cylinder; by default the size
    Vec3 centre{0.0, 0.0, 0.2};      ///< of its bounding box
    Vec3 angles_deg;
    std::string unit = "mm";  ///< of a mesh file's coordinates: mm, cm or m
};
/// Whether it is one of object_kinds().
[[nodiscard]] bool is_built_in(const ObjectSource& source);
/// Whether it is the name of a file. A name that is neither is for open_object() to refuse.
[[nodiscard]] bool names_mesh(const ObjectSource& source);
/// @param read  gets a mesh file's content; by default read_file()
/// @throws Error{bad_input} for files that cannot be used or have no volume, Error{bad_argument} for measures
[[nodiscard]] TouchObject open_object(const ObjectSource& source, const FileReader& read = {});

/// The surface of an object for a view: the file's mesh at its place, or, of a built-in one, where its distance is 0 on
/// a grid of 48 cells along its longest side, so that edges are drawn a little blunt. A half-space is drawn in its box.
/// @throws as open_object()
[[nodiscard]] Mesh surface_of(const ObjectSource& source, const FileReader& read = {});

/// How the name of a script of hand/synthetic.hpp begins, in place of a file's.
inline constexpr std::string_view synthetic_prefix = "synthetic:";

/// A recording as a user names it: a file as load_hands() reads it, or "synthetic:SCRIPT" or "synthetic:SCRIPT:HEIGHT"
/// with the height of the palm in mm, which is one round of the script at 100 frames a second. Behind a file's name may
/// stand that of the tracker's mounting (hand/mounting.hpp), hands.json@desk.toml.
/// @param read  gets a file's content; by default read_file()
/// @throws Error{bad_input} or Error{bad_argument}
[[nodiscard]] HandRecording open_hands(const std::string& name, const std::string& model = {}, double rate_hz = 60.0,
                                       const FileReader& read = {});

/// A hand that feels an object by an algorithm, as a project names them. How fast, how many points, how it is modulated
/// and the seed are the project's.
struct HandSource {
    std::string recording;  ///< as open_hands() takes it
    std::string model;      ///< of a .pose file
    double rate_hz = 60.0;  ///< of a .pose file
    ObjectSource object;
    std::string algorithm = "A";
    std::optional<std::size_t> frame;  ///< only this one, from 1: one pass, which can be repeated
    /// Recording and object that were opened already; they take the place of opening them.
    std::shared_ptr<const HandRecording> hands{};
    std::shared_ptr<const TouchObject> touched{};
};

/// The names of the files that are read for a hand: the recording, a .pose file's bones, and the object's mesh.
[[nodiscard]] std::vector<std::string> files_of(const HandSource& hand);

}  // namespace haptogram
