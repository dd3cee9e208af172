// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/project.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "haptogram/array/millimetres.hpp"
#include "haptogram/base/bundle.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/base/toml_value.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/verbs/settings.hpp"

namespace haptogram {
namespace {

using section::assign;
using section::number_text;
using section::quoted_text;
using section::Section;

constexpr std::string_view format_name = "haptogram-project-1";
constexpr double longest_mm = 1e6;

bool is_up(const std::string& text) { return text == "y" || text == "z"; }

bool is_unit(const std::string& text) { return text == "mm" || text == "cm" || text == "m"; }

std::optional<double> length(const Section& section, std::string_view key) {
    const auto millimetres = section.number(key, 1e-6, longest_mm);
    return millimetres ? std::optional(*millimetres * millimetre) : std::nullopt;
}

void read_placement(Placement& placement, const Section& section) {
    assign(placement.scale, section.number("scale", 1e-9, 1e9));
    placement.size_m = length(section, "size_mm");
    if (const auto angles = section.numbers("rotate_deg", 3))
        std::copy(angles->begin(), angles->end(), placement.rotate_deg.begin());
    if (const auto center = section.numbers("center_mm", 3))
        placement.center = from_mm((*center)[0], (*center)[1], (*center)[2]);
}

ShapeSource read_shape(const std::string& file, const toml::table& table) {
    const Section section(file, table);
    section.only({"file", "unit", "up", "kind", "diameter_mm", "length_mm", "height_mm", "sides", "turns", "scale",
                  "size_mm", "rotate_deg", "center_mm"});
    ShapeSource source;
    assign(source.file, section.text("file"));
    assign(source.primitive.kind, section.text("kind"));
    const std::string where = section::place(file, table);
    if (source.file.empty() == source.primitive.kind.empty())
        throw bad_input(where, "a [[shape]] has either 'file', a shape file, or 'kind', a built-in shape");
    assign(source.unit, section.text("unit", "\"mm\", \"cm\" or \"m\"", is_unit));
    source.up = section.text("up", "\"y\" or \"z\"", is_up);
    source.primitive.diameter = length(section, "diameter_mm");
    source.primitive.length = length(section, "length_mm");
    source.primitive.height = length(section, "height_mm");
    source.primitive.sides = section.whole("sides", 3, 1000);
    source.primitive.turns = section.number("turns", 1e-3, 1e3);
    const PrimitiveSpec& p = source.primitive;
    if (source.file.empty() && source.up)
        throw bad_input(where, "'up' is of shape files; turn built-in shapes by rotate_deg");
    if (!source.file.empty() && (p.diameter || p.length || p.height || p.sides || p.turns))
        throw bad_input(where, "diameter_mm, length_mm, height_mm, sides and turns measure built-in shapes, not files");
    if (source.file.empty() && section.find("unit") != nullptr)
        throw bad_input(section.at("unit"), "unit is that of a file's coordinates; a built-in shape has none");
    if (source.file.empty()) try {
            check_primitive(source.primitive);
        } catch (const Error& error) {
            throw bad_input(error.where() == "shape" ? section.at("kind") : where, error.message());
        }
    read_placement(source.placement, section);
    return source;
}

constexpr std::string_view eases[] = {"linear", "smooth", "step"};  // as Ease has them

/// @param shapes  how many there are
KeyFrame read_key_frame(const std::string& file, const toml::table& table, std::size_t shapes) {
    const Section section(file, table);
    section.only({"time_s", "move_mm", "rotate_deg", "scale", "amplitude", "am_hz", "ease", "mark", "shape"});
    KeyFrame frame;
    frame.time_s = section.required(section.number("time_s", 0.0, 1e6), "time_s", "seconds since the path begins");
    if (const auto move = section.numbers("move_mm", 3)) frame.move = from_mm((*move)[0], (*move)[1], (*move)[2]);
    if (const auto angles = section.numbers("rotate_deg", 3))
        frame.turn_deg = {(*angles)[0], (*angles)[1], (*angles)[2]};
    assign(frame.scale, section.number("scale", 1e-9, 1e9));
    assign(frame.amplitude, section.number("amplitude", 0.0, 1.0));
    assign(frame.am_hz, section.number("am_hz", 0.0, 1e6));
    if (const auto ease = section.text("ease", "\"linear\", \"smooth\" or \"step\"", [](const std::string& text) {
            return std::ranges::find(eases, text) != std::end(eases);
        }))
        frame.ease = static_cast<Ease>(std::ranges::find(eases, *ease) - std::begin(eases));
    assign(frame.mark, section.flag("mark"));
    frame.shape = section.whole("shape", 1, static_cast<std::uint32_t>(std::max<std::size_t>(shapes, 1))).value_or(0);
    return frame;
}

HandSource read_hand(const Section& section) {
    section.only({"recording", "model", "frames_hz", "object", "size_mm", "height_mm", "center_mm", "rotate_deg",
                  "unit", "algorithm", "frame"});
    HandSource hand;
    hand.recording = section.required(section.text("recording"), "recording",
                                      "a file of recorded hands, or \"synthetic:SCRIPT\" in quotes");
    assign(hand.model, section.text("model"));
    assign(hand.rate_hz, section.number("frames_hz", 1e-3, 1e6));
    ObjectSource& object = hand.object;
    assign(object.name, section.text("object"));
    object.size_m = length(section, "size_mm");
    object.height_m = length(section, "height_mm");
    if (const auto center = section.numbers("center_mm", 3))
        object.centre = from_mm((*center)[0], (*center)[1], (*center)[2]);
    if (const auto angles = section.numbers("rotate_deg", 3))
        object.angles_deg = {(*angles)[0], (*angles)[1], (*angles)[2]};
    assign(object.unit, section.text("unit", "\"mm\", \"cm\" or \"m\"", is_unit));
    assign(hand.algorithm, section.text("algorithm", "a letter from A to L", [](const std::string& text) {
        return text.size() == 1 && text[0] >= 'A' && text[0] <= 'L';
    }));
    hand.frame = section.whole("frame", 1, 1'000'000'000);
    return hand;
}

std::string in_words(Choices names) {
    std::string text;
    for (std::size_t one = 0; one < names.size(); ++one)
        text += fmt::format("{}\"{}\"", one == 0 ? "" : one + 1 == names.size() ? " or " : ", ", names[one]);
    return text;
}

struct ReadSetting {
    const Section& section;
    std::string_view key;

    template <class T>
    static std::optional<SettingValue> of(const std::optional<T>& value) {
        return value ? std::optional<SettingValue>(*value) : std::nullopt;
    }
    std::optional<SettingValue> operator()(Flag) const { return of(section.flag(key)); }
    std::optional<SettingValue> operator()(File) const { return of(section.text(key)); }
    std::optional<SettingValue> operator()(FileOrName) const { return of(section.text(key)); }
    std::optional<SettingValue> operator()(const Numbers& n) const { return of(section.number(key, n.least, n.most)); }
    std::optional<SettingValue> operator()(const WholeNumbers& n) const {
        return of(section.whole64(key, n.least, n.most));
    }
    std::optional<SettingValue> operator()(const Form& form) const {
        const std::optional<std::string> text = section.text(key, form.expected);
        if (text && !form.fits(*text)) throw section.wrong(*section.find(key), key, form.expected);
        return of(text);
    }
    std::optional<SettingValue> operator()(Choices names) const {
        const std::optional<std::string> name = section.text(key, in_words(names));
        if (name && std::ranges::find(names, *name) == names.end())
            throw section.wrong(*section.find(key), key, in_words(names));
        return of(name);
    }
    std::optional<SettingValue> operator()(OwnTable) const { return {}; }
};

void read_settings(Project& project, const Section& whole) {
    std::vector<const Setting*> said;
    for (const Setting& one : project_settings()) {
        const std::optional<SettingValue> value = std::visit(ReadSetting{whole, one.key}, one.kind);
        if (!value) continue;
        for (const Setting* other : said)
            if (!one.one_of.empty() && other->one_of == one.one_of)
                throw bad_input(whole.at(one.key),
                                fmt::format("{} and {} both say {}; keep one", other->key, one.key, one.one_of));
        one.put(project, one, *value);
        said.push_back(&one);
    }
}

std::string value_text(bool value) { return value ? "true" : "false"; }
std::string value_text(double value) { return number_text(value); }
std::string value_text(std::uint64_t value) { return fmt::to_string(value); }
std::string value_text(const std::string& value) { return quoted_text(value); }

/// The settings that have an effect and are not as they are without being said.
std::string text_of_settings(const Project& project) {
    std::string text;
    for (const Setting& one : project_settings()) {
        const std::optional<SettingValue> value = one.get == nullptr ? std::nullopt : one.get(project, one);
        if (!value || value == default_of(one) || !why_idle(one.key, project).empty()) continue;
        const auto* whole = std::get_if<WholeNumbers>(&one.kind);
        if (whole != nullptr && std::get<std::uint64_t>(*value) > whole->most)
            throw bad_argument(std::string(one.key),
                               fmt::format("{} is more than a project file can hold; take at most {}",
                                           std::get<std::uint64_t>(*value), whole->most));
        text += fmt::format("{} = {}\n", one.key, std::visit([](const auto& v) { return value_text(v); }, *value));
    }
    return text;
}

std::string in_mm(double metres) { return number_text(exact_mm(metres)); }

/// The keys of a placement that are not as they are without it.
std::string to_toml(const Placement& place) {
    std::string text;
    if (place.scale != 1.0) text += fmt::format("scale = {}\n", number_text(place.scale));
    if (place.size_m) text += fmt::format("size_mm = {}\n", in_mm(*place.size_m));
    if (place.rotate_deg != Placement{}.rotate_deg)
        text += fmt::format("rotate_deg = [{}, {}, {}]\n", number_text(place.rotate_deg[0]),
                            number_text(place.rotate_deg[1]), number_text(place.rotate_deg[2]));
    if (place.center)
        text += fmt::format("center_mm = [{}, {}, {}]\n", in_mm(place.center->x), in_mm(place.center->y),
                            in_mm(place.center->z));
    return text;
}

std::string to_toml(const ShapeSource& source) {
    if (source.content)
        throw bad_argument("shapes", fmt::format("'{}' is only in memory; save it as a file first", source.file));
    std::string text = "\n[[shape]]\n";
    if (!source.file.empty()) {
        text += fmt::format("file = {}\n", quoted_text(source.file));
        if (source.unit != ShapeSource{}.unit) text += fmt::format("unit = {}\n", quoted_text(source.unit));
        if (source.up) text += fmt::format("up = {}\n", quoted_text(*source.up));
        return text + to_toml(source.placement);
    }
    const PrimitiveSpec& p = source.primitive;
    text += fmt::format("kind = {}\n", quoted_text(p.kind));
    if (p.diameter) text += fmt::format("diameter_mm = {}\n", in_mm(*p.diameter));
    if (p.length) text += fmt::format("length_mm = {}\n", in_mm(*p.length));
    if (p.height) text += fmt::format("height_mm = {}\n", in_mm(*p.height));
    if (p.sides) text += fmt::format("sides = {}\n", *p.sides);
    if (p.turns) text += fmt::format("turns = {}\n", number_text(*p.turns));
    return text + to_toml(source.placement);
}

std::string to_toml(const KeyFrame& frame) {
    const KeyFrame standard;
    std::string text = fmt::format("\n[[keyframe]]\ntime_s = {}\n", number_text(frame.time_s));
    if (frame.move != standard.move)
        text += fmt::format("move_mm = [{}, {}, {}]\n", in_mm(frame.move.x), in_mm(frame.move.y), in_mm(frame.move.z));
    if (frame.turn_deg != standard.turn_deg)
        text += fmt::format("rotate_deg = [{}, {}, {}]\n", number_text(frame.turn_deg.x), number_text(frame.turn_deg.y),
                            number_text(frame.turn_deg.z));
    if (frame.scale != standard.scale) text += fmt::format("scale = {}\n", number_text(frame.scale));
    if (frame.amplitude != standard.amplitude) text += fmt::format("amplitude = {}\n", number_text(frame.amplitude));
    if (frame.am_hz != standard.am_hz) text += fmt::format("am_hz = {}\n", number_text(frame.am_hz));
    if (frame.ease != standard.ease)
        text += fmt::format("ease = \"{}\"\n", eases[static_cast<std::size_t>(frame.ease)]);
    if (frame.mark) text += "mark = true\n";
    if (frame.shape != 0) text += fmt::format("shape = {}\n", frame.shape);
    return text;
}

std::string to_toml(const HandSource& hand) {
    const HandSource standard;
    const ObjectSource& object = hand.object;
    std::string text = fmt::format("\n[hand]\nrecording = {}\n", quoted_text(hand.recording));
    if (!hand.model.empty()) text += fmt::format("model = {}\n", quoted_text(hand.model));
    if (hand.rate_hz != standard.rate_hz) text += fmt::format("frames_hz = {}\n", number_text(hand.rate_hz));
    text += fmt::format("object = {}\n", quoted_text(object.name));
    if (object.size_m) text += fmt::format("size_mm = {}\n", in_mm(*object.size_m));
    if (object.height_m) text += fmt::format("height_mm = {}\n", in_mm(*object.height_m));
    if (object.centre != standard.object.centre)
        text += fmt::format("center_mm = [{}, {}, {}]\n", in_mm(object.centre.x), in_mm(object.centre.y),
                            in_mm(object.centre.z));
    if (object.angles_deg != standard.object.angles_deg)
        text += fmt::format("rotate_deg = [{}, {}, {}]\n", number_text(object.angles_deg.x),
                            number_text(object.angles_deg.y), number_text(object.angles_deg.z));
    if (object.unit != standard.object.unit) text += fmt::format("unit = {}\n", quoted_text(object.unit));
    text += fmt::format("algorithm = {}\n", quoted_text(hand.algorithm));
    if (hand.frame) text += fmt::format("frame = {}\n", *hand.frame);
    return text;
}

/// What a project cannot have beside what it plays, because that has its own.
void check_subject(const Project& project, const Section& whole, const std::string& where) {
    if (project.is_of_shapes() && project.shapes.empty())
        throw bad_input(where, "it has no [[shape]]; add one with a 'file' or the 'kind' of a built-in shape");
    if (project.hand && !project.path.empty())
        throw bad_input(whole.at("path"), "path and [hand] both say what is played; keep one");
    for (const Setting& one : project_settings())
        if (!one.key.empty() && whole.find(one.key) != nullptr)
            if (const std::string why = why_idle(one.key, project); !why.empty())
                throw bad_input(whole.at(one.key), fmt::format("{} {}", one.key, why));
}

}  // namespace

Project project_from_toml(std::string_view text, const std::string& where) {
    const toml::table root = section::parse_text(text, where);
    const Section whole(where, root);
    std::vector<std::string_view> known = {"format"};
    for (const Setting& one : project_settings())
        if (!one.key.empty()) known.push_back(one.key);
    whole.only(known);
    const auto format = whole.required(whole.text("format"), "format", fmt::format("\"{}\"", format_name));
    if (format != format_name)
        throw whole.wrong(*whole.find("format"), "format", fmt::format("\"{}\" for this version", format_name));
    Project project;
    read_settings(project, whole);
    const Section place(where, root, "place");
    place.only({"scale", "size_mm", "rotate_deg", "center_mm"});
    read_placement(project.placement, place);
    if (const toml::node* shapes = root.get("shape")) {
        const toml::array* list = shapes->as_array();
        if (list == nullptr || !list->is_array_of_tables())
            throw bad_input(section::place(where, *shapes), "shapes are tables of their own, each under [[shape]]");
        for (const toml::node& shape : *list) project.shapes.push_back(read_shape(where, *shape.as_table()));
    }
    if (const toml::node* frames = root.get("keyframe")) {
        const toml::array* list = frames->as_array();
        if (list == nullptr || !list->is_array_of_tables())
            throw bad_input(section::place(where, *frames),
                            "key frames are tables of their own, each under [[keyframe]]");
        for (const toml::node& frame : *list)
            project.key_frames.push_back(read_key_frame(where, *frame.as_table(), project.shapes.size()));
    }
    if (const Section hand(where, root, "hand"); hand.exists()) project.hand = read_hand(hand);
    project.live = live_table_from_toml(text, where);
    project.triggers = triggers_from_toml(text, where);
    check_subject(project, whole, where);
    return project;
}

std::string from_here(const std::string& name) {
    for (const std::string kind : {"wav:", "csv:"})
        if (name.starts_with(kind)) return kind + std::filesystem::absolute(name.substr(kind.size())).string();
    return name.ends_with(".toml") ? std::filesystem::absolute(name).string() : name;
}

std::filesystem::path project_file(const std::filesystem::path& path) {
    return is_bundle(path) ? path / "project.toml" : path;
}

std::vector<std::string> files_of(const Project& project) {
    std::vector<std::string> files;
    for (const ShapeSource& shape : project.shapes)
        if (!shape.file.empty()) files.push_back(shape.file);
    if (!project.path.empty()) files.push_back(project.path);
    for (const std::optional<std::string>& name : {project.array, project.board})
        if (name && name->ends_with(".toml")) files.push_back(*name);
    for (const std::string kind : {"wav:", "csv:"})
        if (project.am.starts_with(kind)) files.push_back(project.am.substr(kind.size()));
    if (project.hand) std::ranges::move(files_of(*project.hand), std::back_inserter(files));
    return files;
}

Project load_project(const std::filesystem::path& path) {
    const std::filesystem::path file = project_file(path);
    Project project = project_from_toml(read_file(file), file.string());
    project.folder = file.parent_path();
    for (const std::string& name : files_of(project)) (void)named_in(project.folder, name);
    return project;
}

std::string to_toml(const Project& project) {
    std::string text = fmt::format("format = \"{}\"\n", format_name) + text_of_settings(project);
    if (project.hand) text += to_toml(*project.hand);
    const std::string placed = to_toml(project.placement);
    if (!placed.empty()) text += "\n[place]\n" + placed;
    for (const ShapeSource& shape : project.shapes) text += to_toml(shape);
    for (const KeyFrame& frame : project.key_frames) text += to_toml(frame);
    return text + to_toml(project.triggers) + to_toml(project.live);
}

bool is_project(const std::string& path) { return path.ends_with(".toml") || is_bundle(path); }

}  // namespace haptogram
