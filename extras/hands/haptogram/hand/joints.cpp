// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/joints.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "haptogram/base/json_member.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

/// The 26 joints of OpenXR's XR_EXT_hand_tracking.
constexpr std::array<std::string_view, 26> known_joints{"palm",
                                                        "wrist",
                                                        "thumb_metacarpal",
                                                        "thumb_proximal",
                                                        "thumb_distal",
                                                        "thumb_tip",
                                                        "index_metacarpal",
                                                        "index_proximal",
                                                        "index_intermediate",
                                                        "index_distal",
                                                        "index_tip",
                                                        "middle_metacarpal",
                                                        "middle_proximal",
                                                        "middle_intermediate",
                                                        "middle_distal",
                                                        "middle_tip",
                                                        "ring_metacarpal",
                                                        "ring_proximal",
                                                        "ring_intermediate",
                                                        "ring_distal",
                                                        "ring_tip",
                                                        "little_metacarpal",
                                                        "little_proximal",
                                                        "little_intermediate",
                                                        "little_distal",
                                                        "little_tip"};

/// From a tracker's frame to the array's.
Vec3 vector_of(const JsonMember& member, double most) {
    const std::vector<JsonMember> parts = member.list();
    if (parts.size() != 3) throw member.wrong("three numbers");
    const auto part = [&](std::size_t i) { return parts[i].number(-most, most); };
    return {part(0), -part(2), part(1)};
}

Vec3 unit(Vec3 v, const JsonMember& of, std::string_view expected) {
    const double length = norm(v);
    if (!(length > 1e-9)) throw of.wrong(expected);
    return v * (1.0 / length);
}

Hand hand_of(const JsonMember& json, const std::string& where) {
    json.only(
        {"side", "id", "joints_m", "normal", "direction", "velocity_m_s", "confidence", "grab", "pinch", "widths_m"});
    Hand hand;
    const JsonMember side = json.at("side");
    hand.right = side.text() == "right";
    if (!hand.right && side.text() != "left") throw side.wrong("\"left\" or \"right\"");
    hand.id = hand.right ? 1 : 0;
    if (const auto id = json.find("id")) hand.id = std::llround(id->number(-9e15, 9e15));
    const JsonMember joints = json.at("joints_m");
    for (const auto& [name, place] : joints.object().items())
        if (std::ranges::find(known_joints, name) == known_joints.end())
            throw bad_input(where, fmt::format("found the joint {}, expected the names of OpenXR: {}", shown(name),
                                               fmt::join(known_joints, ", ")));
    constexpr double most_m = 1e3;
    const auto place_of = [&](std::string_view name) { return vector_of(joints.at(std::string(name)), most_m); };
    for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
        // A thumb has a bone less, so its chain begins with the metacarpal.
        const std::size_t first = finger == 0 ? 2 : 2 + 5 * finger;
        const auto is_there = [&](std::size_t i) {
            return joints.find(std::string(known_joints.at(first + i))).has_value();
        };
        if (!is_there(0) && !is_there(1) && !is_there(2) && !is_there(3)) continue;
        Finger& made = hand.fingers.at(finger).emplace();
        for (std::size_t i = 0; i < 4; ++i) made.joints.at(i) = place_of(known_joints.at(first + i));
    }
    if (const auto widths = json.find("widths_m")) {
        const std::vector<JsonMember> each = widths->list();
        if (each.size() != hand.fingers.size()) throw widths->wrong("five numbers, from the thumb on");
        for (std::size_t i = 0; i < each.size(); ++i)
            if (hand.fingers.at(i)) hand.fingers.at(i)->width_m = each[i].number(1e-3, 0.1);
    }
    const auto given = [&](const char* name, auto otherwise) {
        const auto found = json.find(name);
        return found ? unit(vector_of(*found, 1e3), *found, "a direction") : otherwise();
    };
    // By default from the joints around the palm.
    const auto to = [&](std::string_view name) { return place_of(name) - place_of("wrist"); };
    constexpr std::string_view apart =
        "joints of which the wrist, and the proximal ones of index, middle and little finger, lie apart";
    hand.normal = given("normal", [&] {
        return unit(cross(to("index_proximal"), to("little_proximal")) * (hand.right ? 1.0 : -1.0), joints, apart);
    });
    hand.direction = given("direction", [&] {
        const Vec3 out = to("middle_proximal");
        return unit(out - dot(out, hand.normal) * hand.normal, joints, apart);
    });
    hand.palm = joints.find("palm") ? place_of("palm") : 0.5 * (place_of("wrist") + place_of("middle_proximal"));
    const auto fraction = [&](const char* name, double& value) {
        if (const auto found = json.find(name)) value = found->number(0.0, 1.0);
    };
    fraction("confidence", hand.confidence);
    fraction("grab", hand.grab);
    fraction("pinch", hand.pinch);
    return hand;
}

}  // namespace

HandFrame JointLines::frame(std::string_view text, const std::string& where) {
    const nlohmann::ordered_json document = parse_json(text, where);
    const JsonMember root(document, where);
    root.only({"time_s", "hands"});
    HandFrame frame;
    frame.time_s = root.at("time_s").number(-1e12, 1e12);
    for (const JsonMember& each : root.at("hands").list()) {
        Hand hand = hand_of(each, where);
        const auto is_same = [&hand](const Hand& other) { return other.id == hand.id; };
        if (std::ranges::any_of(frame.hands, is_same))
            throw each.at("side").wrong("another hand than before, or an \"id\"");
        const auto before = std::ranges::find_if(last_.hands, is_same);
        const double since_s = frame.time_s - last_.time_s;
        if (const auto velocity = each.find("velocity_m_s"))
            hand.velocity = vector_of(*velocity, 1e3);
        else if (before != last_.hands.end() && since_s > 0.0)
            hand.velocity = (hand.palm - before->palm) * (1.0 / since_s);
        frame.hands.push_back(std::move(hand));
    }
    return last_ = frame;
}

HandRecording recording_from_joints(std::string_view text, const std::string& where) {
    HandRecording recording;
    JointLines reader;
    for (Lines lines(text); lines.next();) {
        if (lines.line().find_first_not_of(" \t\r") == std::string_view::npos) continue;
        const std::string place = at_line(where, lines.number());
        HandFrame frame = reader.frame(lines.line(), place);
        if (!recording.frames.empty() && frame.time_s < recording.frames.back().time_s)
            throw bad_input(place,
                            fmt::format("found the time {} s, expected a later one than the line before has, {} s",
                                        frame.time_s, recording.frames.back().time_s));
        recording.frames.push_back(std::move(frame));
    }
    if (recording.frames.empty()) throw bad_input(where, "it has no frames; expected a line a frame, as JSON");
    const double start_s = recording.frames.front().time_s;
    for (HandFrame& frame : recording.frames) frame.time_s -= start_s;
    return recording;
}

}  // namespace haptogram
