// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "haptogram/hand/hand.hpp"

namespace haptogram {

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

/// Reads a recording; its ending tells the format: .pose, or .json and .lz as leap.hpp reads them.
/// @param model    of .pose, the file of its bones; empty: model_hand.json beside it
/// @param rate_hz  of .pose
/// @param read     gets the contents; by default read_file()
/// @throws Error{bad_input} also for another ending
[[nodiscard]] HandRecording load_hands(const std::filesystem::path& file, const std::filesystem::path& model = {},
                                       double rate_hz = 60.0, const FileReader& read = {});

}  // namespace haptogram
