// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/leap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/json_member.hpp"

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

HandRecording recording_from_leap(std::string_view text, const std::string& where) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    const bool compressed = begin != std::string_view::npos && text[begin] != '{';
    const nlohmann::ordered_json document =
        compressed ? parse_json(from_lz_string(text.substr(begin), where), where) : parse_json(text, where);
    const JsonMember root(document, where);
    std::vector<JsonMember> frames = root.at("frames").list();
    std::optional<Head> head;
    if (!frames.empty() && frames.front().value().is_array()) {
        head = head_of(frames.front());
        frames.erase(frames.begin());
    }
    if (frames.empty()) throw root.at("frames").wrong("a list of at least one frame");
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

}  // namespace haptogram
