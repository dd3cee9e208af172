// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/pose_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/json_member.hpp"
#include "haptogram/hand/leap.hpp"
#include "haptogram/verbs/hand_source.hpp"

namespace haptogram {
namespace {

constexpr double largest_m = 1e3;
constexpr std::size_t numbers_a_bone = 7;

Vec3 vector_of(const JsonMember& member) {
    const std::vector<JsonMember> parts = member.list();
    if (parts.size() != 3) throw member.wrong("three numbers");
    const auto part = [&](std::size_t i) { return parts[i].number(-largest_m, largest_m); };
    return {part(0), part(1), part(2)};
}

std::size_t index_of(const JsonMember& member, std::size_t count) {
    const double value = member.number(0.0, static_cast<double>(count) - 1.0);
    if (value != std::floor(value)) throw member.wrong("a whole number");
    return static_cast<std::size_t>(value);
}

HandBones::Bone bone_of(const JsonMember& cage) {
    std::vector<Vec3> corners;
    for (const JsonMember& corner : cage.at("verts").list()) corners.push_back(vector_of(corner));
    if (corners.size() < 4) throw cage.at("verts").wrong("at least four corners");
    // The cage as tetrahedra from one of its corners: their volumes, and their centres weighted by them.
    double volume = 0.0;
    Vec3 moment;
    const Vec3 origin = corners.front();
    for (const JsonMember& face : cage.at("faces").list()) {
        std::vector<Vec3> around;
        for (const JsonMember& corner : face.list())
            around.push_back(corners[index_of(corner, corners.size())] - origin);
        for (std::size_t i = 2; i < around.size(); ++i) {
            const double part = dot(around[0], cross(around[i - 1], around[i])) / 6.0;
            volume += part;
            moment = moment + 0.25 * part * (around[0] + around[i - 1] + around[i]);
        }
    }
    if (!(std::abs(volume) > 0.0)) throw cage.wrong("a closed cage with a volume");
    HandBones::Bone bone;
    bone.centre = origin + moment * (1.0 / volume);
    bone.tip = bone.centre;
    for (const Vec3& corner : corners) bone.tip.z = std::max(bone.tip.z, corner.z);
    return bone;
}

/// Where a bone is and how it is turned.
struct BonePose {
    Vec3 centre, axis;  ///< the quaternion's vector
    double w = 1.0;
    [[nodiscard]] Vec3 turned(Vec3 v) const {
        const Vec3 twice = 2.0 * cross(axis, v);
        return v + w * twice + cross(axis, twice);
    }
    /// A point of the bone in the camera's frame.
    [[nodiscard]] Vec3 place(const HandBones::Bone& bone, Vec3 point) const {
        return centre + turned(point - bone.centre);
    }
};

std::vector<double> numbers_of(std::string_view line, const std::string& where) {
    constexpr std::string_view blank = " \t\r";
    std::vector<double> numbers;
    while (true) {
        const std::size_t begin = line.find_first_not_of(blank);
        if (begin == std::string_view::npos) return numbers;
        line.remove_prefix(begin);
        const std::string_view word = line.substr(0, line.find_first_of(blank));
        double value = 0.0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size() || !(std::abs(value) <= largest_m))
            throw bad_input(where, fmt::format("number {} is \"{}\"; expected a number of at most {} m",
                                               numbers.size() + 1, word.substr(0, 40), largest_m));
        numbers.push_back(value);
        line.remove_prefix(word.size());
    }
}

Hand hand_of(const std::vector<double>& numbers, const HandBones& model, const std::string& where) {
    std::array<BonePose, HandBones::count> poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const double* const n = numbers.data() + numbers_a_bone * i;
        const double length = std::sqrt(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6]);
        if (std::abs(length - 1.0) > 1e-3)
            throw bad_input(where,
                            fmt::format("the quaternion of bone {} has the length {:.4g}; expected 1", i, length));
        const double scale = 1.0 / length;
        poses.at(i) = {{n[0], n[1], n[2]}, Vec3{n[3], n[4], n[5]} * scale, n[6] * scale};
    }
    Hand hand;
    constexpr std::size_t palm = 1;
    hand.palm = poses[palm].centre;
    hand.normal = poses[palm].turned({0.0, -1.0, 0.0});
    hand.direction = poses[palm].turned({0.0, 0.0, 1.0});
    for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
        Finger& made = hand.fingers.at(finger).emplace();
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t bone = palm + 1 + 3 * finger + i;
            // The far end is the next bone's joint; only the last bone's own end is the finger's tip.
            made.joints.at(i) = poses.at(bone).place(model.bones.at(bone), model.bones.at(bone).joint);
            made.joints.at(i + 1) = poses.at(bone).place(model.bones.at(bone), model.bones.at(bone).tip);
        }
    }
    return hand;
}

}  // namespace

HandBones bones_from_json(std::string_view text, const std::string& where) {
    const nlohmann::ordered_json document = parse_json(text, where);
    const JsonMember root(document, where);
    const std::vector<JsonMember> cages = root.at("controlcages").list();
    if (cages.size() != HandBones::count) throw root.at("controlcages").wrong("a list of 17 bones");
    HandBones model;
    for (std::size_t i = 0; i < cages.size(); ++i) model.bones.at(i) = bone_of(cages[i]);
    std::array<bool, HandBones::count> joined{};
    for (const JsonMember& joint : root.at("joints").list()) {
        const std::size_t bone = index_of(joint.at("rbi1"), HandBones::count);
        const std::size_t before = index_of(joint.at("rbi0"), HandBones::count);
        // A finger's first bone hangs on the palm, and every other on the one before it.
        const std::size_t expected = bone < 2 ? 0 : (bone - 2) % 3 == 0 ? 1 : bone - 1;
        if (bone == 0 || before != expected || joined.at(bone))
            throw joint.at("rbi0").wrong(fmt::format("bone {} for bone {}, once", expected, bone));
        joined.at(bone) = true;
        model.bones.at(bone).joint = vector_of(joint.at("p1"));
    }
    for (std::size_t bone = 1; bone < joined.size(); ++bone)
        if (!joined.at(bone)) throw root.at("joints").wrong(fmt::format("a list with a joint of bone {}", bone));
    return model;
}

HandRecording recording_from_poses(std::string_view text, const std::string& where, const HandBones& bones,
                                   double rate_hz) {
    if (!(rate_hz > 0.0) || !std::isfinite(rate_hz))
        throw bad_argument("hand_rate",
                           fmt::format("found {}, expected a positive number of frames a second", rate_hz));
    HandRecording recording;
    std::size_t number = 0;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string line = fmt::format("{}:{}", where, ++number);
        const std::vector<double> numbers = numbers_of(text.substr(0, end), line);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (numbers.empty()) continue;
        if (numbers.size() != numbers_a_bone * HandBones::count)
            throw bad_input(line,
                            fmt::format("found {} numbers, expected 119: of 17 bones x y z and a quaternion x y z w",
                                        numbers.size()));
        HandFrame& frame = recording.frames.emplace_back();
        frame.time_s = static_cast<double>(recording.frames.size() - 1) / rate_hz;
        frame.hands.push_back(hand_of(numbers, bones, line));
    }
    if (recording.frames.empty()) throw bad_input(where, "it has no poses; expected a line a frame");
    // The palm's velocity, by the frames before and after.
    for (std::size_t i = 0; i < recording.frames.size() && recording.frames.size() > 1; ++i) {
        const HandFrame& before = recording.frames[i == 0 ? 0 : i - 1];
        const HandFrame& after = recording.frames[std::min(i + 1, recording.frames.size() - 1)];
        recording.frames[i].hands.front().velocity =
            (after.hands.front().palm - before.hands.front().palm) * (1.0 / (after.time_s - before.time_s));
    }
    return recording;
}

HandRecording load_hands(const std::filesystem::path& file, const std::filesystem::path& model, double rate_hz,
                         const FileReader& read) {
    const auto content = [&](const std::filesystem::path& path) { return read ? read(path) : read_file(path); };
    const std::string ending = ending_of(file);
    if (ending == ".json" || ending == ".lz") return recording_from_leap(content(file), file.string());
    if (ending != ".pose")
        throw bad_input(file.string(),
                        "the name of a recording of hands ends in .json or .lz (Leap) or .pose; rename or convert it");
    const std::filesystem::path bones = bones_file(file, model);
    return recording_from_poses(content(file), file.string(), bones_from_json(content(bones), bones.string()), rate_hz);
}

}  // namespace haptogram
