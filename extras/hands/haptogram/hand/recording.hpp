// SPDX-License-Identifier: Apache-2.0
// Opens what a rendering is of: a recording of hands, and the object that they feel.
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "haptogram/hand/hand.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/shape/shape.hpp"
#include "haptogram/verbs/hand_source.hpp"

namespace haptogram {

/// Reads a recording of LeapJS Playback: JSON with an object a frame, or the packed format 2, whose first entry lists
/// the members of the others. The text may be compressed by LZString to base64. The Leap's x, y (up) and z (to the
/// user), in millimetres, become x, z and −y of the array frame, in metres.
/// @param where  names the file in messages
/// @throws Error{bad_input} for damaged text, and naming the place of what is missing or mistyped
[[nodiscard]] HandRecording recording_from_leap(std::string_view text, const std::string& where);
[[nodiscard]] HandRecording load_leap(const std::filesystem::path& file);

/// A message of the WebSocket of a Leap's tracking service, protocol 6: a frame, in the same frame and units, with the
/// tracker's own time; or nothing when it is another message, such as the service's version.
/// @throws Error{bad_input} as above
[[nodiscard]] std::optional<HandFrame> frame_from_leap_message(std::string_view json, const std::string& where);

/// The text that LZString compressed to base64 (Pieroxy's lz-string, compressToBase64).
/// @throws Error{bad_input} when the text is cut short or damaged
[[nodiscard]] std::string from_lz_string(std::string_view base64, const std::string& where);

/// What a row of bones needs to become a hand: of each bone, in its own coordinates, metres.
struct HandBones {
    static constexpr std::size_t count = 17;  ///< wrist, palm, and three of each finger from the thumb on
    struct Bone {
        Vec3 centre;  ///< of mass; a pose says where it is
        Vec3 joint;   ///< to the bone before it
        Vec3 tip;     ///< the far end, on the line through the centre along z
    };
    std::array<Bone, count> bones;
};

/// Reads the hand model of Intel's hand tracking samples: JSON with a closed control cage of each bone and the joints
/// between them. The centre of mass is that of the cage's volume. Other members are not looked at.
/// @param where  names the file in messages
/// @throws Error{bad_input} naming what is missing, mistyped, or has no volume
[[nodiscard]] HandBones bones_from_json(std::string_view text, const std::string& where);

/// Reads poses of those samples: a line a frame, 17 bones each, x y z (metres, of the centre of mass) and a quaternion
/// x y z w. They are in the frame of a depth camera, which looks along z with x to the right and y down; we put that
/// camera into the array's centre, so that its frame is the array's. The file has no times, and knows right hands only.
/// The palm faces −y of its bone, and fingers point along z.
/// @param rate_hz  frames a second
/// @throws Error{bad_input} naming the line, for other numbers of numbers, for what is no number, and for quaternions
/// whose length is not 1; Error{bad_argument} for a rate that is not positive
[[nodiscard]] HandRecording recording_from_poses(std::string_view text, const std::string& where,
                                                 const HandBones& bones, double rate_hz);

/// How the content of a file is got: from the disk, unless somebody has it in memory.
using FileReader = std::function<std::string(const std::filesystem::path&)>;

/// Reads a recording; its ending tells the format: .pose, .jsonl (hand/joints.hpp), or .json and .lz of
/// a Leap.
/// @param model    of .pose, the file of its bones; empty: model_hand.json beside it
/// @param rate_hz  of .pose
/// @param read     gets the contents; by default read_file()
/// @throws Error{bad_input} also for another ending
[[nodiscard]] HandRecording load_hands(const std::filesystem::path& file, const std::filesystem::path& model = {},
                                       double rate_hz = 60.0, const FileReader& read = {});

/// What a synthetic hand does. It repeats after its time.
enum class HandScript {
    press,  ///< an open hand goes down by 30 mm and up again, in 2 s
    slide,  ///< an open hand goes 60 mm to the side and back, in 3 s
    grasp,  ///< the fingers bend by 70° at each of their two outer joints and open again, in 2 s
    wave,   ///< an open hand turns 30° to either side about its wrist, in 1 s
};

/// The script of a name: press, slide, grasp or wave.
/// @throws Error{bad_argument} for another name
[[nodiscard]] HandScript hand_script(std::string_view name);

/// Length of a script, after which the script repeats.
[[nodiscard]] double seconds_of(HandScript script);

/// A right hand of a usual size at a time of its script: palm down, fingers along y. All moves are smooth, and the
/// velocity is their exact derivative.
/// @param height_m  of the palm above the array when the script begins
[[nodiscard]] Hand synthetic_hand(HandScript script, double time_s, double height_m = 0.2);

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
