// SPDX-License-Identifier: Apache-2.0
#include "messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <optional>
#include <utility>

#include "haptogram/base/depth.hpp"
#include "haptogram/shape/place.hpp"

namespace haptogram::studio {
namespace {

using nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the layouts are those of the processor's memory");

/// A message's members, each of which must be asked for.
class Members {
public:
    Members(const ordered_json& message, std::string type) : message_(message), type_(std::move(type)) {}

    [[nodiscard]] const std::string& type() const { return type_; }
    void only(std::initializer_list<std::string_view> known) const {
        for (const auto& [key, value] : message_.items())
            if (key != "t" && std::find(known.begin(), known.end(), key) == known.end())
                throw bad_input(type_, fmt::format("unknown member '{}'", key));
    }
    [[nodiscard]] const ordered_json& get(const char* name, bool right, const char* expected) const {
        if (!right) throw bad_input(type_, fmt::format("member '{}' is missing or not {}", name, expected));
        return message_[name];
    }
    [[nodiscard]] bool has(const char* name) const { return message_.contains(name); }
    [[nodiscard]] std::uint32_t whole(const char* name) const {
        const bool right = has(name) && message_[name].is_number_unsigned() &&
                           message_[name].get<std::uint64_t>() <= std::numeric_limits<std::uint32_t>::max();
        return get(name, right, "a whole number of 32 bits").get<std::uint32_t>();
    }
    [[nodiscard]] std::uint16_t whole16(const char* name) const {
        const std::uint32_t found = whole(name);
        return static_cast<std::uint16_t>(get(name, found <= 0xffff, "a whole number of 16 bits").get<std::uint32_t>());
    }
    /// Of objects, so many at most.
    [[nodiscard]] const ordered_json& list(const char* name, std::size_t most) const {
        const bool right = has(name) && message_[name].is_array() && message_[name].size() <= most &&
                           std::all_of(message_[name].begin(), message_[name].end(),
                                       [](const ordered_json& each) { return each.is_object(); });
        return get(name, right, fmt::format("a list of objects, {} at most", most).c_str());
    }
    [[nodiscard]] std::string text(const char* name) const {
        return get(name, has(name) && message_[name].is_string(), "text").get<std::string>();
    }
    /// Text of at most so many bytes, without control characters unless they are `allowed`.
    [[nodiscard]] std::string short_text(const char* name, std::size_t longest, std::string_view allowed = {}) const {
        std::string found = text(name);
        const bool controls = std::any_of(found.begin(), found.end(), [&](char each) {
            return (static_cast<unsigned char>(each) < 32 || each == 127) &&
                   allowed.find(each) == std::string_view::npos;
        });
        if (found.size() > longest || controls)
            throw bad_input(type_, fmt::format("member '{}' has {} bytes{}; expected at most {}, and no control "
                                               "characters",
                                               name, found.size(), controls ? ", some of control" : "", longest));
        return found;
    }
    /// Name of a file without a path: it can only be in the folder where it is looked for.
    [[nodiscard]] std::string file_name(const char* name, std::string_view ending = {}) const {
        std::string found = text(name);
        const auto plain = [](char each) {
            return (each >= 'a' && each <= 'z') || (each >= 'A' && each <= 'Z') || (each >= '0' && each <= '9') ||
                   each == '_';
        };
        const bool right = !found.empty() && found.size() <= longest_name && plain(found.front()) &&
                           found.ends_with(ending) && std::all_of(found.begin(), found.end(), [&](char each) {
                               return plain(each) || each == '-' || each == '.';
                           });
        if (!right)
            throw bad_input(type_, fmt::format("member '{}' is no name of a file{}{}; expected letters, digits, _, - "
                                               "and ., beginning with a letter, a digit or _, {} at most",
                                               name, ending.empty() ? "" : " that ends in ", ending, longest_name));
        return found;
    }
    /// From 0 to 1.
    [[nodiscard]] double share(const char* name) const {
        const double value = has(name) && message_[name].is_number() ? message_[name].get<double>() : -1.0;
        return get(name, value >= 0.0 && value <= 1.0, "a number from 0 to 1").get<double>();
    }
    [[nodiscard]] bool truth(const char* name) const {
        return get(name, has(name) && message_[name].is_boolean(), "true or false").get<bool>();
    }
    [[nodiscard]] Vec3 millimetres(const char* name) const {
        const bool right = has(name) && message_[name].is_array() && message_[name].size() == 3 &&
                           std::all_of(message_[name].begin(), message_[name].end(),
                                       [](const ordered_json& each) { return each.is_number(); });
        const ordered_json& found = get(name, right, "three numbers");
        return from_mm(found[0].get<double>(), found[1].get<double>(), found[2].get<double>());
    }
    /// Of places, so many at most, their coordinates in a row.
    [[nodiscard]] std::vector<Vec3> places(const char* name, std::size_t most) const {
        const bool right = has(name) && message_[name].is_array() && !message_[name].empty() &&
                           message_[name].size() <= 3 * most && message_[name].size() % 3 == 0 &&
                           std::all_of(message_[name].begin(), message_[name].end(),
                                       [](const ordered_json& each) { return each.is_number(); });
        const ordered_json& found =
            get(name, right, fmt::format("three numbers for each of 1 to {} places", most).c_str());
        std::vector<Vec3> all;
        for (std::size_t i = 0; i < found.size(); i += 3)
            all.push_back(from_mm(found[i].get<double>(), found[i + 1].get<double>(), found[i + 2].get<double>()));
        return all;
    }
    [[nodiscard]] ordered_json object(const char* name) const {
        return get(name, has(name) && message_[name].is_object(), "an object");
    }

private:
    const ordered_json& message_;
    std::string type_;
};

/// Refuses what could not be a message of a page and would keep the server from STOP: lists within lists, which take
/// the stack of whoever copies them, and names by the thousand, each of which is compared with all before it. A text
/// that is no JSON may pass; the parser refuses it.
void require_modest(std::string_view text) {
    require_shallow(text, "message");
    std::size_t members = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '"') quoted = !quoted;
        if (quoted && text[i] == '\\') ++i;
        if (!quoted && text[i] == ':' && ++members > most_members)
            throw bad_input("message", fmt::format("it has more than {} members; take fewer shapes", most_members));
    }
}

template <class T>
void put(std::vector<std::uint8_t>& bytes, std::size_t at, T value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

void append(std::vector<float>& values, Vec3 point) {
    for (const double each : {point.x, point.y, point.z}) values.push_back(static_cast<float>(each / millimetre));
}

using Triangle = std::array<std::uint32_t, 3>;  ///< numbers of vertices

/// Of triangles with the same corners the first; none that is a line or a point. By sorting, as a set takes a block of
/// memory for each.
std::vector<Triangle> once(const std::vector<Triangle>& triangles) {
    std::vector<std::pair<Triangle, std::size_t>> sorted;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        Triangle corners = triangles[i];
        std::sort(corners.begin(), corners.end());
        if (corners[0] != corners[1] && corners[1] != corners[2]) sorted.emplace_back(corners, i);
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < sorted.size(); ++i)
        if (i == 0 || sorted[i].first != sorted[i - 1].first) places.push_back(sorted[i].second);
    std::sort(places.begin(), places.end());
    std::vector<Triangle> kept;
    for (const std::size_t place : places) kept.push_back(triangles[place]);
    return kept;
}

/// A mesh of fewer triangles for drawing: a vertex becomes the first one of those in its cell of a grid, which has so
/// many cells along the longest side of the mesh. What becomes a line or a point, or is there already, is left out.
std::vector<Triangle> coarser(const Mesh& mesh, double cells) {
    const Box box = bounding_box(Shape{{mesh}});
    const Vec3 extent = box.extent();
    const double cell = std::max({extent.x, extent.y, extent.z}) / cells;
    const double per_m = cell > 0.0 ? 1.0 / cell : 0.0;
    constexpr std::uint32_t nobody = ~std::uint32_t{0};
    const auto side = static_cast<std::size_t>(cells) + 2;
    std::vector<std::uint32_t> first_in(side * side * side, nobody), becomes;
    for (const Vec3& vertex : mesh.vertices) {
        const Vec3 place = per_m * (vertex - box.low);
        std::size_t at = 0;
        for (const double each : {place.x, place.y, place.z})
            at = at * side + static_cast<std::size_t>(std::lround(each));
        if (first_in[at] == nobody) first_in[at] = static_cast<std::uint32_t>(becomes.size());
        becomes.push_back(first_in[at]);
    }
    std::vector<Triangle> triangles;
    for (const auto& [a, b, c] : mesh.triangles) triangles.push_back({becomes[a], becomes[b], becomes[c]});
    return once(triangles);
}

/// The triangles of a mesh that are drawn, `most` at most.
std::vector<Triangle> drawn(const Mesh& mesh, std::size_t most) {
    std::vector<Triangle> triangles = mesh.triangles;
    for (double cells = 96.0; triangles.size() > most; cells /= 1.5) triangles = coarser(mesh, cells);
    return triangles;
}

template <class T>
void append_bytes(std::vector<std::uint8_t>& bytes, const std::vector<T>& values) {
    const auto* const begin = reinterpret_cast<const std::uint8_t*>(values.data());
    bytes.insert(bytes.end(), begin, begin + sizeof(T) * values.size());
}

/// What is drawn of a shape: float32 x, y, z of each, and triangles by the numbers of their vertices.
struct Drawing {
    std::vector<float> vertices, segments, points;
    std::vector<std::uint32_t> triangles;
};

/// Adds a mesh's triangles, with those of its vertices that they have.
void append(Drawing& drawing, const Mesh& mesh, const std::vector<Triangle>& triangles) {
    std::vector<std::optional<std::uint32_t>> number(mesh.vertices.size());
    for (const auto& triangle : triangles)
        for (const std::uint32_t corner : triangle) {
            if (!number[corner]) {
                number[corner] = static_cast<std::uint32_t>(drawing.vertices.size() / 3);
                append(drawing.vertices, mesh.vertices[corner]);
            }
            drawing.triangles.push_back(*number[corner]);
        }
}

/// @param triangles, points  that the shape has
std::vector<std::uint8_t> drawn_bytes(std::uint32_t n, const Drawing& drawing, std::size_t triangles,
                                      std::size_t points) {
    std::vector<std::uint8_t> bytes(64);
    std::memcpy(bytes.data(), "HOB1", 4);
    put(bytes, 4, n);
    put(bytes, 8, static_cast<std::uint32_t>(drawing.vertices.size() / 3));
    put(bytes, 12, static_cast<std::uint32_t>(drawing.triangles.size() / 3));
    put(bytes, 16, static_cast<std::uint32_t>(drawing.segments.size() / 6));
    put(bytes, 20, static_cast<std::uint32_t>(drawing.points.size() / 3));
    put(bytes, 24, static_cast<std::uint32_t>(triangles));
    put(bytes, 28, static_cast<std::uint32_t>(points));
    append_bytes(bytes, drawing.vertices);
    append_bytes(bytes, drawing.triangles);
    append_bytes(bytes, drawing.segments);
    append_bytes(bytes, drawing.points);
    return bytes;
}

/// Every so many-th of `count`, so that at most `most` are taken.
std::size_t stride(std::size_t count, std::size_t most) { return std::max<std::size_t>(1, (count + most - 1) / most); }

/// All but the places, and which record.
SliceMessage field_of(const Members& members) {
    SliceMessage slice{.n = members.whole("n"), .scene = members.text("scene"), .view = members.whole("view")};
    if (slice.view >= most_views)
        throw bad_input(members.type(),
                        fmt::format("member 'view' is {}, and a page has views 0 to {}", slice.view, most_views - 1));
    return slice;
}

SliceMessage slice_of(const Members& members) {
    SliceMessage slice = field_of(members);
    slice.slice = {members.millimetres("origin"), members.millimetres("u"), members.millimetres("v"),
                   members.whole("width"), members.whole("height")};
    return slice;
}

std::vector<TriggeredPart> triggers_of(const Members& members) {
    std::vector<TriggeredPart> parts;
    if (!members.has("triggers")) return parts;
    for (const ordered_json& each : members.list("triggers", most_triggers)) {
        const Members part(each, fmt::format("{}, trigger {}", members.type(), parts.size() + 1));
        part.only({"first", "length", "loops", "pin"});
        parts.push_back({part.whole16("first"), part.whole16("length"), part.whole16("loops"), part.truth("pin")});
    }
    return parts;
}

}  // namespace

Message read_message(std::string_view text) {
    require_modest(text);
    ordered_json message;
    try {
        message = ordered_json::parse(text);
    } catch (const ordered_json::exception& error) {
        throw bad_input("message", fmt::format("no JSON: {}", error.what()));
    }
    if (!message.is_object() || !message.contains("t") || !message["t"].is_string())
        throw bad_input("message", "expected an object with the member 't', the name of the message");
    const std::string type = message["t"];
    const Members members(message, fmt::format("message '{}'", type));
    if (type == "scene") {
        members.only({"n", "document"});
        return SceneMessage{members.whole("n"), members.object("document")};
    }
    if (type == "hand") {
        members.only({"n", "document", "drawn"});
        return HandMessage{members.whole("n"), members.object("document"), members.short_text("drawn", longest_name)};
    }
    if (type == "path") {
        members.only({"n", "document"});
        return PathMessage{members.whole("n"), members.object("document")};
    }
    if (type == "slice") {
        members.only({"n", "scene", "origin", "u", "v", "width", "height", "record", "view"});
        SliceMessage slice = slice_of(members);
        slice.record = members.whole("record");
        return slice;
    }
    if (type == "reach") {
        members.only({"n", "scene", "origin", "u", "v", "width", "height", "view"});
        return ReachMessage{slice_of(members)};
    }
    if (type == "skin") {
        members.only({"n", "scene", "points", "record", "view"});
        SkinMessage skin{field_of(members), members.places("points", most_skin_points)};
        skin.slice.record = members.whole("record");
        skin.slice.slice.width = static_cast<std::uint32_t>(skin.points.size());
        skin.slice.slice.height = 1;
        return skin;
    }
    if (type == "drives") {
        members.only({"n", "scene", "record"});
        return DrivesMessage{members.whole("n"), members.text("scene"), members.whole("record")};
    }
    if (type == "analyze") {
        members.only({"n", "scene"});
        return AnalyzeMessage{members.whole("n"), members.text("scene")};
    }
    if (type == "simulate") {
        members.only({"n", "scene"});
        return SimulateMessage{members.whole("n"), members.text("scene")};
    }
    if (type == "cancel") {
        members.only({"n", "what"});
        const std::string what = members.short_text("what", longest_name);
        if (what != "analyze" && what != "simulate")
            throw bad_input(members.type(), fmt::format("member 'what' is '{}', not 'analyze' or 'simulate'", what));
        using What = CancelMessage::What;
        return CancelMessage{members.whole("n"), what == "analyze" ? What::analyze : What::simulate};
    }
    if (type == "pulses") {
        members.only({"n", "index", "periods"});
        return PulsesMessage{members.whole("n"), members.whole("index"), members.whole("periods")};
    }
    if (type == "connect") {
        members.only({"n", "port", "scene", "baud"});
        return ConnectMessage{members.whole("n"), members.text("port"), members.text("scene"),
                              members.has("baud") ? members.whole("baud") : 0};
    }
    if (type == "disconnect") {
        members.only({"n"});
        return DisconnectMessage{members.whole("n")};
    }
    if (type == "upload") {
        members.only({"n", "scene"});
        return UploadMessage{members.whole("n"), members.text("scene")};
    }
    if (type == "play") {
        members.only({"n", "scene", "triggers", "lines"});
        return PlayMessage{members.whole("n"), members.text("scene"), triggers_of(members),
                           members.has("lines") ? members.text("lines") : ""};
    }
    if (type == "trigger") {
        members.only({"n", "number"});
        return TriggerMessage{members.whole("n"), members.whole("number")};
    }
    if (type == "stream") {
        members.only({"n", "scene", "index"});
        return StreamMessage{members.whole("n"), members.text("scene"), members.whole("index")};
    }
    if (type == "intensity") {
        members.only({"n", "value"});
        return IntensityMessage{members.whole("n"), members.share("value")};
    }
    if (type == "modulate") {
        members.only({"n", "scene"});
        return ModulateMessage{members.whole("n"), members.text("scene")};
    }
    if (type == "studies") {
        members.only({"n"});
        return StudiesMessage{members.whole("n")};
    }
    if (type == "study") {
        members.only({"n", "protocol", "participant", "seed", "results", "port"});
        StudyMessage study{
            members.whole("n"),    members.file_name("protocol"),          members.whole("participant"),
            members.whole("seed"), members.file_name("results", ".jsonl"), members.short_text("port", longest_port)};
        if (study.participant < 1 || study.participant > most_participant)
            throw bad_input("message 'study'", fmt::format("member 'participant' is {}, expected 1 to {}",
                                                           study.participant, most_participant));
        return study;
    }
    if (type == "live") {
        members.only({"n", "document", "from"});
        return LiveMessage{members.whole("n"), members.object("document"), members.short_text("from", longest_port)};
    }
    if (type == "answer") {
        members.only({"n", "number", "text"});
        return AnswerMessage{members.whole("n"), members.whole("number"),
                             members.short_text("text", longest_answer, "\n\t")};
    }
    if (type == "leave") {
        members.only({"n"});
        return LeaveMessage{members.whole("n")};
    }
    if (type == "stop") {
        members.only({"n"});
        return StopMessage{members.whole("n")};
    }
    if (type == "beat") {
        members.only({"hidden"});
        return BeatMessage{members.truth("hidden")};
    }
    throw bad_input("message", fmt::format("there is no message '{}'", type));
}

std::string to_text(const ordered_json& message) {
    return message.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json to_json(const Error& error) {
    return {{"where", error.where()}, {"message", error.message()}, {"remedies", error.remedies()}};
}

std::vector<std::uint8_t> slice_bytes(const SliceMessage& asked, const std::vector<float>& values,
                                      double skin_per_square, double took_ms, std::size_t sets) {
    std::vector<std::uint8_t> bytes(64 + sizeof(float) * values.size());
    const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
    std::memcpy(bytes.data(), "HSL1", 4);
    put(bytes, 4, asked.n);
    put(bytes, 8, asked.slice.width);
    put(bytes, 12, asked.slice.height);
    put(bytes, 16, *least);
    put(bytes, 20, *greatest);
    put(bytes, 24, static_cast<float>(skin_per_square));
    put(bytes, 28, static_cast<float>(took_ms));
    put(bytes, 32, static_cast<std::uint32_t>(sets));
    std::memcpy(bytes.data() + 36, asked.scene.data(), std::min<std::size_t>(28, asked.scene.size()));
    std::memcpy(bytes.data() + 64, values.data(), sizeof(float) * values.size());
    return bytes;
}

std::vector<std::uint8_t> shape_bytes(std::uint32_t n, const Shape& shape) {
    Drawing drawing;
    std::size_t triangles = 0, points = 0;
    for (const Piece& piece : shape.pieces) {
        if (const auto* const mesh = std::get_if<Mesh>(&piece)) triangles += mesh->triangles.size();
        if (const auto* const cloud = std::get_if<Cloud>(&piece)) points += cloud->points.size();
    }
    for (const Piece& piece : shape.pieces) {
        if (const auto* const mesh = std::get_if<Mesh>(&piece)) {
            const double share = static_cast<double>(mesh->triangles.size()) / static_cast<double>(triangles);
            append(drawing, *mesh, drawn(*mesh, static_cast<std::size_t>(share * most_drawn_triangles)));
        } else if (const auto* const curve = std::get_if<Curve>(&piece)) {
            constexpr int segments = 200;
            for (int i = 0; i < segments; ++i)
                for (const int end : {i, i + 1}) append(drawing.segments, curve->at(curve->length * end / segments));
        } else {
            const Cloud& cloud = std::get<Cloud>(piece);
            for (std::size_t i = 0; i < cloud.points.size(); i += stride(points, most_drawn_points))
                append(drawing.points, cloud.points[i]);
        }
    }
    return drawn_bytes(n, drawing, triangles, points);
}

std::vector<std::uint8_t> touched_bytes(std::uint32_t n, const Mesh& surface, const std::vector<Edge>& edges) {
    Drawing drawing;
    append(drawing, surface, drawn(surface, most_drawn_triangles));
    for (const Edge& edge : edges)
        for (std::size_t i = 0; i + 1 < edge.size(); ++i)
            for (const Vec3& end : {edge[i], edge[i + 1]}) append(drawing.segments, end);
    return drawn_bytes(n, drawing, surface.triangles.size(), 0);
}

std::vector<std::uint8_t> hand_bytes(std::uint32_t n, const HandView& view) {
    std::array<std::vector<float>, 4> corners;  // of the skin, felt and weak segments, foci
    for (const auto& triangle : view.skin)
        for (const Vec3& corner : triangle) append(corners[0], corner);
    for (const auto& segment : view.strong)
        for (const Vec3& end : segment) append(corners[1], end);
    for (const auto& segment : view.weak)
        for (const Vec3& end : segment) append(corners[2], end);
    for (const Vec3& focus : view.foci) append(corners[3], focus);
    std::vector<std::uint8_t> bytes(64);
    std::memcpy(bytes.data(), "HHA1", 4);
    put(bytes, 4, n);
    put(bytes, 8, static_cast<std::uint32_t>(view.skin.size()));
    put(bytes, 12, static_cast<std::uint32_t>(view.strong.size()));
    put(bytes, 16, static_cast<std::uint32_t>(view.weak.size()));
    put(bytes, 20, static_cast<std::uint32_t>(view.foci.size()));
    for (const std::vector<float>& each : corners) append_bytes(bytes, each);
    return bytes;
}

ordered_json to_json(const HandView& view) {
    ordered_json lines = ordered_json::array();
    for (const SkinLine& line : view.lines)
        lines.push_back({{"kind", name_of(line.kind)}, {"length_mm", length_of(line) / millimetre}});
    return {{"frame", view.frame},
            {"frames", view.frames},
            {"time_s", view.time_s},
            {"end_s", view.end_s},
            {"pass_s", view.pass_s},
            {"lines", lines},
            {"report", view.report ? to_json(*view.report) : ordered_json()},
            {"warnings", view.warnings},
            {"nothing", view.nothing ? to_json(*view.nothing) : ordered_json()}};
}

}  // namespace haptogram::studio
