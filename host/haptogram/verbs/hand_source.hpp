// SPDX-License-Identifier: Apache-2.0
// What a rendering is of, as a user names it: a recording of hands, and the object that they feel. What becomes of it
// is in extras/hands (hand/recording.hpp, hand/project.hpp).
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/shape/readers.hpp"

namespace haptogram {

struct HandRecording;
struct TouchObject;

/// The built-in objects: sphere, cube, …
[[nodiscard]] std::span<const std::string_view> object_kinds();
/// Whether it has a height besides its size.
[[nodiscard]] bool has_height(std::string_view kind);

/// An object as a user names it.
struct ObjectSource {
    std::string name = "sphere";     ///< a kind of object_kinds(), or a mesh file
    std::optional<double> size_m;    ///< by default 100 mm, and a mesh as it is
    std::optional<double> height_m;  ///< of a cone, a pyramid and a cylinder; by default the size
    Vec3 centre{0.0, 0.0, 0.2};      ///< of its bounding box
    Vec3 angles_deg;
    std::string unit = "mm";  ///< of a mesh file's coordinates: mm, cm, m or inch
    ShapeReaders readers{};   ///< of formats that the core does not read
};
/// Whether it is one of object_kinds().
[[nodiscard]] bool is_built_in(const ObjectSource& source);
/// Whether it is the name of a file. A name that is neither is for open_object() to refuse.
[[nodiscard]] bool names_mesh(const ObjectSource& source);

/// How the name of a script of hand/recording.hpp begins, in place of a file's.
inline constexpr std::string_view synthetic_prefix = "synthetic:";

/// A recording's name without that of the tracker's mounting behind it, and the latter, hands.json@desk.toml.
[[nodiscard]] std::pair<std::string, std::string> without_mounting(const std::string& name);
/// The file of the bones of a .pose file: the model, or model_hand.json beside it.
[[nodiscard]] std::filesystem::path bones_file(const std::filesystem::path& file, const std::filesystem::path& model);

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
