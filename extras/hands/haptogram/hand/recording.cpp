// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <variant>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/json_member.hpp"
#include "haptogram/hand/joints.hpp"
#include "haptogram/hand/mounting.hpp"
#include "haptogram/shape/import.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/hand_source.hpp"
#include "haptogram/verbs/iso_surface.hpp"

namespace haptogram {
namespace {

constexpr double largest_mm = 1e6;
constexpr std::size_t most_characters = std::size_t{1}
                                        << 25U;  ///< of a decompressed recording; the longest known have 1/5

/// Bits of base64 text, the first character's highest bit first. Numbers come with their lowest bit first.
class Bits {
public:
    Bits(std::string_view base64, const std::string& where) : text_(base64), where_(where) {}

    std::uint32_t take(unsigned count) {
        std::uint32_t value = 0;
        for (unsigned i = 0; i < count; ++i) value |= next() << i;
        return value;
    }

private:
    std::uint32_t next() {
        if (left_ == 0) {
            while (at_ < text_.size() && (text_[at_] == '\n' || text_[at_] == '\r')) ++at_;
            constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
            const std::size_t digit = at_ < text_.size() ? digits.find(text_[at_]) : std::string_view::npos;
            if (digit == std::string_view::npos)
                throw bad_input(where_,
                                fmt::format("compressed text ends or is damaged at byte {}; copy the file again", at_));
            ++at_;
            digit_ = static_cast<std::uint32_t>(digit);
            left_ = 6;
        }
        return digit_ >> --left_ & 1U;
    }

    std::string_view text_;
    const std::string& where_;
    std::size_t at_ = 0;
    std::uint32_t digit_ = 0;
    unsigned left_ = 0;
};

void append_utf8(std::string& text, char32_t c) {
    if (c < 0x80) {
        text += static_cast<char>(c);
    } else if (c < 0x800) {
        text += static_cast<char>(0xC0 | c >> 6);
        text += static_cast<char>(0x80 | (c & 0x3F));
    } else {
        text += static_cast<char>(0xE0 | c >> 12);
        text += static_cast<char>(0x80 | (c >> 6 & 0x3F));
        text += static_cast<char>(0x80 | (c & 0x3F));
    }
}

/// From the Leap's frame, mm, to the array's, in the same unit.
Vec3 turned(Vec3 leap) { return {leap.x, -leap.z, leap.y}; }

Vec3 millimetres_of(const JsonMember& member) {
    const std::vector<JsonMember> parts = member.list();
    if (parts.size() != 3) throw member.wrong("three numbers");
    const auto part = [&](std::size_t i) { return parts[i].number(-largest_mm, largest_mm); };
    return {part(0), part(1), part(2)};
}

Vec3 place_of(const JsonMember& member) { return turned(millimetres_of(member)) * millimetre; }

Vec3 unit_of(const JsonMember& member) {
    const Vec3 v = turned(millimetres_of(member));
    const double length = norm(v);
    if (!(length > 0.5 && length < 2.0)) throw member.wrong("a direction, of length 1");
    return v * (1.0 / length);
}

/// A frame, a hand or a finger, whose members have names, or places in a list that the packed format's head gives.
class Entry {
public:
    using Names = std::map<std::string, std::size_t>;
    Entry(JsonMember json, const Names* names) : json_(std::move(json)), names_(names) {
        if (names_ != nullptr) list_ = json_.list();
    }

    [[nodiscard]] std::optional<JsonMember> find(const std::string& name) const {
        if (names_ == nullptr) return json_.find(name);
        const auto found = names_->find(name);
        if (found == names_->end()) return {};
        if (found->second >= list_.size()) throw json_.wrong(fmt::format("a list with {}", name));
        return list_[found->second];
    }

    [[nodiscard]] JsonMember at(const std::string& name) const {
        if (auto found = find(name)) return *std::move(found);
        throw json_.wrong(fmt::format("an entry with {}", name));
    }

private:
    JsonMember json_;
    const Names* names_;
    std::vector<JsonMember> list_;
};

/// What the first entry of the packed format says of the others: where each member is.
struct Head {
    Entry::Names frame, hand, finger;
};

Entry::Names names_of(const JsonMember& list) {
    Entry::Names names;
    for (const JsonMember& name : list.list()) names.emplace(name.text(), names.size());
    return names;
}

Head head_of(const JsonMember& entry) {
    Head head;
    std::size_t place = 0;
    for (const JsonMember& member : entry.list()) {
        if (member.value().is_string()) {
            head.frame.emplace(member.text(), place++);
            continue;
        }
        if (member.object().size() != 1) throw member.wrong("an object with one list of names");
        const std::string name = member.object().begin().key();
        head.frame.emplace(name, place++);
        if (name != "hands" && name != "pointables") continue;
        const std::vector<JsonMember> lists = member.at(name).list();
        if (lists.size() != 1) throw member.wrong("an object with one list of names");
        (name == "hands" ? head.hand : head.finger) = names_of(lists.front());
    }
    return head;
}

std::int64_t id_of(const JsonMember& member) { return std::llround(member.number(-9e15, 9e15)); }

Hand hand_of(const Entry& entry) {
    Hand hand;
    hand.id = id_of(entry.at("id"));
    const JsonMember type = entry.at("type");
    if (type.text() != "left" && type.text() != "right") throw type.wrong("\"left\" or \"right\"");
    hand.right = type.text() == "right";
    hand.palm = place_of(entry.at("palmPosition"));
    hand.normal = unit_of(entry.at("palmNormal"));
    hand.direction = unit_of(entry.at("direction"));
    hand.velocity = place_of(entry.at("palmVelocity"));
    const auto fraction = [&](const char* name, double& value) {
        if (const auto found = entry.find(name)) value = found->number(0.0, 1.0);
    };
    fraction("confidence", hand.confidence);
    fraction("grabStrength", hand.grab);
    fraction("pinchStrength", hand.pinch);
    return hand;
}

void add_finger(HandFrame& frame, const Entry& entry) {
    if (const auto tool = entry.find("tool"); tool && tool->value().is_boolean() && tool->value().get<bool>()) return;
    const JsonMember owner = entry.at("handId");
    const auto hand = std::find_if(frame.hands.begin(), frame.hands.end(),
                                   [id = id_of(owner)](const Hand& one) { return one.id == id; });
    if (hand == frame.hands.end()) throw owner.wrong("the id of one of the frame's hands");
    // A finger's id is its hand's, and a digit that tells which finger it is.
    const std::int64_t id = id_of(entry.at("id"));
    const auto type = entry.find("type");
    const std::int64_t which = type ? id_of(*type) : id - 10 * hand->id;
    if (which < 0 || which > 4) throw entry.at("id").wrong("that of one of five fingers");
    Finger finger;
    constexpr std::array<const char*, 4> names{"mcpPosition", "pipPosition", "dipPosition", "tipPosition"};
    for (std::size_t i = 0; i < names.size(); ++i) finger.joints.at(i) = place_of(entry.at(names.at(i)));
    if (const auto width = entry.find("width")) finger.width_m = width->number(1.0, 100.0) * millimetre;
    hand->fingers.at(static_cast<std::size_t>(which)) = finger;
}

HandFrame frame_of(const JsonMember& json, const Head* head) {
    const Entry entry(json, head == nullptr ? nullptr : &head->frame);
    HandFrame frame;
    frame.time_s = entry.at("timestamp").number(0.0, 1e18) * 1e-6;
    for (const JsonMember& hand : entry.at("hands").list())
        frame.hands.push_back(hand_of({hand, head == nullptr ? nullptr : &head->hand}));
    for (const JsonMember& finger : entry.at("pointables").list())
        add_finger(frame, {finger, head == nullptr ? nullptr : &head->finger});
    return frame;
}

}  // namespace

std::string from_lz_string(std::string_view base64, const std::string& where) {
    // A dictionary coder like LZ78: codes 0 and 1 bring a new character of 8 or 16 bits, 2 is the end, and every other
    // one repeats what the dictionary has. Each step adds what the last one had and the first character of this one.
    Bits bits(base64, where);
    const auto character = [&](std::uint32_t code) { return std::u32string(1, bits.take(code == 0 ? 8 : 16)); };
    const std::uint32_t first = bits.take(2);
    if (first == 2) return {};
    if (first == 3) throw bad_input(where, "not compressed by LZString; copy the file again");
    std::vector<std::u32string> dictionary(3);
    std::u32string last = character(first);
    dictionary.push_back(last);
    std::u32string whole = last;
    std::size_t widen = 4;  // until a code needs another bit
    const auto grown = [&](unsigned& width) {
        if (--widen == 0) widen = std::size_t{1} << width++;
    };
    for (unsigned width = 3;;) {
        std::uint32_t code = bits.take(width);
        if (code == 2) break;
        if (code < 2) {
            dictionary.push_back(character(code));
            code = static_cast<std::uint32_t>(dictionary.size() - 1);
            grown(width);
        }
        if (code > dictionary.size() || width > 30)
            throw bad_input(where, "damaged compressed text; copy the file again");
        const std::u32string now = code < dictionary.size() ? dictionary[code] : last + last.front();
        whole += now;
        if (whole.size() > most_characters)
            throw bad_input(where,
                            fmt::format("it expands to more than {} characters; cut the recording", most_characters));
        dictionary.push_back(last + now.front());
        grown(width);
        last = now;
    }
    std::string text;
    for (const char32_t c : whole) append_utf8(text, c);
    return text;
}

namespace {
constexpr std::string_view other_trackers =
    "write hands of another tracker as joints, a line a frame, into a file .jsonl (haptogram.sensors.joints does)";
}  // namespace

HandRecording recording_from_leap(std::string_view text, const std::string& where) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin != std::string_view::npos && text[begin] == '[')
        throw bad_input(where, fmt::format("found a list, expected a recording of a Leap; {}", other_trackers));
    const bool compressed = begin != std::string_view::npos && text[begin] != '{';
    const nlohmann::ordered_json document =
        compressed ? parse_json(from_lz_string(text.substr(begin), where), where) : parse_json(text, where);
    const JsonMember root(document, where);
    if (!root.find("frames"))
        throw bad_input(where, fmt::format("it has no frames, expected a recording of a Leap; {}", other_trackers));
    std::vector<JsonMember> frames = root.at("frames").list();
    std::optional<Head> head;
    if (!frames.empty() && frames.front().value().is_array()) {
        head = head_of(frames.front());
        frames.erase(frames.begin());
    }
    if (frames.empty()) throw root.at("frames").wrong("a list of at least one frame");
    if (!head && frames.front().value().is_object() && !frames.front().find("timestamp"))
        throw bad_input(
            where, fmt::format("its first frame has no timestamp, expected a recording of a Leap; {}", other_trackers));
    HandRecording recording;
    for (const JsonMember& json : frames) {
        HandFrame frame = frame_of(json, head ? &*head : nullptr);
        if (!recording.frames.empty() && frame.time_s < recording.frames.back().time_s)
            throw json.wrong("a frame later than the one before it");
        recording.frames.push_back(std::move(frame));
    }
    const double start_s = recording.frames.front().time_s;
    for (HandFrame& frame : recording.frames) frame.time_s -= start_s;
    return recording;
}

std::optional<HandFrame> frame_from_leap_message(std::string_view json, const std::string& where) {
    const nlohmann::ordered_json document = parse_json(json, where);
    const JsonMember root(document, where);
    if (!root.value().is_object()) throw root.wrong("an object");
    if (!root.find("hands")) return {};
    return frame_of(root, nullptr);
}

HandRecording load_leap(const std::filesystem::path& file) {
    return recording_from_leap(read_file(file), file.string());
}

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
    if (ending == ".jsonl") return recording_from_joints(content(file), file.string());
    if (ending != ".pose")
        throw bad_input(
            file.string(),
            "the name of a recording of hands ends in .json or .lz (Leap), .jsonl (joints of any tracker) or "
            ".pose; rename or convert it");
    const std::filesystem::path bones = bones_file(file, model);
    return recording_from_poses(content(file), file.string(), bones_from_json(content(bones), bones.string()), rate_hz);
}

namespace {

using std::numbers::pi;

/// From 0 to 1 and back in one period, and its derivative by time.
struct Swing {
    double value, rate;
};

Swing swing(double time_s, double period_s) {
    const double turns = 2.0 * pi * time_s / period_s;
    return {0.5 - 0.5 * std::cos(turns), pi / period_s * std::sin(turns)};
}

/// A finger that leaves the palm's centre at `knuckle` in the direction `out_deg` from y, with three segments, mm. It
/// bends towards −z, by `bend` at each of its two outer joints.
Finger finger(Vec3 knuckle, double out_deg, const std::array<double, 3>& lengths, double bend) {
    const double out = out_deg * pi / 180.0;
    const Vec3 along{std::sin(out), std::cos(out), 0.0};
    Finger made;
    Vec3 at = knuckle;
    made.joints[0] = at * millimetre;
    for (std::size_t i = 0; i < 3; ++i) {
        const double angle = bend * static_cast<double>(i);
        at = at + lengths.at(i) * (std::cos(angle) * along - std::sin(angle) * Vec3{0, 0, 1});
        made.joints.at(i + 1) = at * millimetre;
    }
    return made;
}

Vec3 about_z(Vec3 p, double angle) {
    return {p.x * std::cos(angle) - p.y * std::sin(angle), p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
}

}  // namespace

HandScript hand_script(std::string_view name) {
    if (name == "press") return HandScript::press;
    if (name == "slide") return HandScript::slide;
    if (name == "grasp") return HandScript::grasp;
    if (name == "wave") return HandScript::wave;
    throw bad_argument("hand", fmt::format("found \"{}\", expected press, slide, grasp or wave", name));
}

double seconds_of(HandScript script) {
    return script == HandScript::slide ? 3.0 : script == HandScript::wave ? 1.0 : 2.0;
}

Hand synthetic_hand(HandScript script, double time_s, double height_m) {
    Hand hand;
    double bend = 0.0;
    hand.palm = {0, 0, height_m};
    double turn = 0.0, turn_rate = 0.0;
    if (script == HandScript::press) {
        const Swing s = swing(time_s, seconds_of(script));
        hand.palm.z -= 0.03 * s.value;
        hand.velocity.z = -0.03 * s.rate;
    } else if (script == HandScript::slide) {
        const Swing s = swing(time_s, seconds_of(script));
        hand.palm.x += 0.06 * s.value;
        hand.velocity.x = 0.06 * s.rate;
    } else if (script == HandScript::grasp) {
        const Swing s = swing(time_s, seconds_of(script));
        bend = 70.0 * pi / 180.0 * s.value;
        hand.grab = s.value;
    } else {
        const double turns = 2.0 * pi * time_s / seconds_of(script);
        turn = pi / 6.0 * std::sin(turns);
        turn_rate = pi / 6.0 * 2.0 * pi * std::cos(turns);
    }
    // A palm-down right hand has its thumb on the side of −x.
    hand.fingers = {finger({-38, -20, 0}, -45, {46, 32, 27}, 0.5 * bend), finger({-27, 45, 0}, -8, {40, 23, 20}, bend),
                    finger({-8, 47, 0}, 0, {44, 27, 21}, bend), finger({11, 44, 0}, 6, {41, 26, 21}, bend),
                    finger({28, 38, 0}, 14, {33, 19, 19}, bend)};
    const Vec3 wrist{0, -0.05, 0};  // from the palm's centre
    const Vec3 centre = wrist + about_z(Vec3{} - wrist, turn);
    hand.palm = hand.palm + centre;
    hand.velocity = hand.velocity + turn_rate * cross({0, 0, 1}, centre - wrist);
    hand.direction = about_z(hand.direction, turn);
    for (auto& one : hand.fingers)
        for (Vec3& joint : one->joints) joint = hand.palm + about_z(joint, turn);
    return hand;
}

namespace {

/// The mesh of a file at its place.
Mesh mesh_of(const ObjectSource& source, const FileReader& read) {
    if (!names_mesh(source))
        throw bad_argument("object", fmt::format("found \"{}\", expected {} or a mesh file", source.name,
                                                 fmt::join(object_kinds(), ", ")));
    if (source.height_m) throw bad_argument("height", "is of built-in objects; a mesh is scaled by its size");
    const double metres = metres_per_unit(source.unit);
    Placement placement;
    placement.size_m = source.size_m;
    placement.rotate_deg = {source.angles_deg.x, source.angles_deg.y, source.angles_deg.z};
    placement.center = source.centre;
    const ShapeFormat format = shape_format(source.name);
    const std::string content = read ? read(source.name) : read_file(source.name);
    Shape shape = load_shape({content, source.name, !read}, format, metres, source.readers);
    if (format == ShapeFormat::gltf) shape = stood_up(std::move(shape));
    shape = placed_at(shape, placement);
    if (shape.pieces.size() != 1 || !std::holds_alternative<Mesh>(shape.pieces.front()))
        throw bad_input(source.name, "it has points without faces, and so no volume; give a closed mesh");
    if (const std::string& flaw = std::get<Mesh>(shape.pieces.front()).flaw; !flaw.empty())
        throw bad_input(source.name, flaw);
    return std::get<Mesh>(std::move(shape.pieces.front()));
}

/// Points from low to high, one beyond at either end.
std::vector<double> points_over(double low, double high, double step) {
    std::vector<double> points;
    const auto count = static_cast<int>(std::ceil((high - low) / step));
    for (int i = -1; i <= count + 1; ++i) points.push_back(low + i * step);
    return points;
}

}  // namespace

TouchObject open_object(const ObjectSource& source, const FileReader& read) {
    if (is_built_in(source)) {
        ObjectMeasures measures;
        measures.size = source.size_m.value_or(measures.size);
        measures.height = source.height_m.value_or(measures.size);
        measures.centre = source.centre;
        measures.angles_deg = source.angles_deg;
        return built_in_object(source.name, measures);
    }
    const Mesh mesh = mesh_of(source, read);
    try {
        return mesh_object(source.name, mesh.vertices, mesh.triangles);
    } catch (const Error& error) {
        throw Error(error.code(), source.name, error.message());
    }
}

Mesh surface_of(const ObjectSource& source, const FileReader& read) {
    if (!is_built_in(source)) return mesh_of(source, read);
    constexpr double cells = 48.0;
    const TouchObject object = open_object(source);
    const Vec3 extent = object.high - object.low;
    const double step = std::max({extent.x, extent.y, extent.z}) / cells;
    Field field;
    Grid& grid = field.region.grid;
    grid.x = points_over(object.low.x, object.high.x, step);
    grid.y = points_over(object.low.y, object.high.y, step);
    grid.z = points_over(object.low.z, object.high.z, step);
    std::vector<float>& depths = field.parts.emplace_back();
    for (std::size_t i = 0; i < grid.size(); ++i)
        depths.push_back(static_cast<float>(-object.solid.distance(grid.point(i))));
    Mesh mesh;
    for (const std::array<Vec3, 3>& triangle : iso_surface(field, 0.0).triangles) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), triangle.begin(), triangle.end());
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

HandRecording open_hands(const std::string& name, const std::string& model, double rate_hz, const FileReader& read) {
    if (!name.starts_with(synthetic_prefix)) {
        const auto [file, mounting] = without_mounting(name);
        HandRecording recording = load_hands(file, model, rate_hz, read);
        if (mounting.empty()) return recording;
        const Pose pose = mounting_from_toml(read ? read(mounting) : read_file(mounting), mounting);
        for (HandFrame& frame : recording.frames) frame = mounted(std::move(frame), pose);
        return recording;
    }
    const std::string text = name.substr(synthetic_prefix.size());
    const std::size_t colon = std::min(text.find(':'), text.size());
    const HandScript script = hand_script(text.substr(0, colon));
    double height_mm = 200.0;
    if (colon < text.size()) {
        const char* const begin = text.data() + colon + 1;
        const char* const end = text.data() + text.size();
        const auto [next, error] = std::from_chars(begin, end, height_mm);
        if (error != std::errc() || next != end || !(height_mm > 0.0 && height_mm < 1e4))
            throw bad_argument("hand",
                               fmt::format("the height in mm after {} is \"{}\"; expected a positive number",
                                           name.substr(0, synthetic_prefix.size() + colon), std::string(begin, end)));
    }
    constexpr double frames_hz = 100.0;
    HandRecording recording;
    const auto count = static_cast<std::size_t>(std::lround(seconds_of(script) * frames_hz));
    for (std::size_t i = 0; i < count; ++i) {
        const double time_s = static_cast<double>(i) / frames_hz;
        recording.frames.push_back({time_s, {synthetic_hand(script, time_s, height_mm * millimetre)}});
    }
    return recording;
}

}  // namespace haptogram
