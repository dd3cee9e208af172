// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/project.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "haptogram/base/bundle.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/shape/primitives.hpp"
#include "haptogram/verbs/settings.hpp"

namespace haptogram {
namespace {

using section::number_text;
using section::quoted_text;
using section::Section;

constexpr std::string_view format_name = "haptogram-project-1";

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
    std::optional<SettingValue> operator()(Length) const {
        return of(section.number(key, Length::least_mm, Length::most_mm));
    }
    std::optional<SettingValue> three(double most) const {
        const auto list = section.numbers(key, 3);
        if (!list) return {};
        for (const double one : *list)
            if (!(std::abs(one) <= most))
                throw section.wrong(*section.find(key), key, fmt::format("three numbers from {} to {}", -most, most));
        return std::array{(*list)[0], (*list)[1], (*list)[2]};
    }
    std::optional<SettingValue> operator()(Place) const { return three(Place::most_mm); }
    std::optional<SettingValue> operator()(Turn) const { return three(Turn::most_deg); }
    std::optional<SettingValue> operator()(Table) const { return {}; }
};

template <class Owner>
void read_settings(Owner& owner, const Section& section, Settings<Owner> settings) {
    std::vector<const SettingText*> said;
    for (const SettingOf<Owner>& one : settings) {
        const std::optional<SettingValue> value = std::visit(ReadSetting{section, one.key}, one.kind);
        if (!value && !one.needed.empty()) throw section.missing(one.key, one.needed);
        if (!value) continue;
        for (const SettingText* other : said)
            if (!one.one_of.empty() && other->one_of == one.one_of)
                throw bad_input(section.at(one.key),
                                fmt::format("{} and {} both say {}; keep one", other->key, one.key, one.one_of));
        one.put(owner, one, *value);
        said.push_back(&one);
    }
}

/// @param what  the owner is
template <class Owner>
void require_effect(const Owner& owner, const Section& section, Settings<Owner> settings, const std::string& what) {
    for (const SettingOf<Owner>& one : settings)
        if (section.find(one.key) != nullptr && !one.has_effect(owner))
            throw bad_input(section.at(one.key),
                            fmt::format("{} is of {}, and this is {}", one.key, one.subject, what));
}

template <class... Owners>
void require_known(const Section& section, std::vector<std::string_view> known, Settings<Owners>... tables) {
    const auto add = [&known](const auto& table) {
        for (const SettingText& one : table) known.push_back(one.key);
    };
    (add(tables), ...);
    section.only(known);
}

ShapeSource read_shape(const Section& section, const std::string& where) {
    require_known(section, {}, shape_settings(), place_settings());
    ShapeSource source;
    read_settings(source, section, shape_settings());
    if (source.file.empty() == source.primitive.kind.empty())
        throw bad_input(where, "a [[shape]] has either 'file', a shape file, or 'kind', a built-in shape");
    require_effect(source, section, shape_settings(), source.file.empty() ? "built in" : "a file");
    if (source.file.empty()) try {
            check_primitive(source.primitive);
        } catch (const Error& error) {
            throw bad_input(where, error.message());
        }
    read_settings(source.placement, section, place_settings());
    return source;
}

/// @param shapes  how many there are
KeyFrame read_key_frame(const Section& section, std::size_t shapes) {
    require_known(section, {}, key_frame_settings());
    KeyFrame frame;
    read_settings(frame, section, key_frame_settings());
    if (const std::size_t most = std::max<std::size_t>(shapes, 1); frame.shape > most)
        throw section.wrong(*section.find("shape"), "shape", fmt::format("a whole number from 1 to {}", most));
    return frame;
}

HandSource read_hand(const Section& section) {
    require_known(section, {}, hand_settings(), object_settings());
    HandSource hand;
    read_settings(hand, section, hand_settings());
    read_settings(hand.object, section, object_settings());
    require_effect(hand, section, hand_settings(), hand.recording);
    require_effect(hand.object, section, object_settings(), names_mesh(hand.object) ? "a mesh file" : hand.object.name);
    return hand;
}

/// The tables of one kind, each under its heading in two pairs of brackets.
/// @param what  they are, in words
template <class T, class Read>
void read_tables(std::vector<T>& found, const toml::table& root, const std::string& where, std::string_view key,
                 std::string_view what, Read read) {
    const toml::node* tables = root.get(key);
    if (tables == nullptr) return;
    const toml::array* list = tables->as_array();
    if (list == nullptr || !list->is_array_of_tables())
        throw bad_input(section::place(where, *tables),
                        fmt::format("{} are tables of their own, each under [[{}]]", what, key));
    for (const toml::node& table : *list)
        found.push_back(read(Section(where, *table.as_table()), section::place(where, table)));
}

std::string value_text(bool value) { return value ? "true" : "false"; }
std::string value_text(double value) { return number_text(value); }
std::string value_text(std::uint64_t value) { return fmt::to_string(value); }
std::string value_text(const std::string& value) { return quoted_text(value); }
std::string value_text(const std::array<double, 3>& value) {
    return fmt::format("[{}, {}, {}]", number_text(value[0]), number_text(value[1]), number_text(value[2]));
}

/// The settings that must be there, or have an effect and are not as they are without being said.
template <class Owner>
std::string text_of(const Owner& owner, Settings<Owner> settings) {
    std::string text;
    for (const SettingOf<Owner>& one : settings) {
        const std::optional<SettingValue> value = one.get == nullptr ? std::nullopt : one.get(owner, one);
        if (!value || (one.needed.empty() && value == default_of(one)) || !one.has_effect(owner)) continue;
        const auto* whole = std::get_if<WholeNumbers>(&one.kind);
        if (whole != nullptr && std::get<std::uint64_t>(*value) > whole->most)
            throw bad_argument(std::string(one.key),
                               fmt::format("{} is more than a project file can hold; take at most {}",
                                           std::get<std::uint64_t>(*value), whole->most));
        text += fmt::format("{} = {}\n", one.key, std::visit([](const auto& v) { return value_text(v); }, *value));
    }
    return text;
}

std::string to_toml(const ShapeSource& source) {
    if (source.content)
        throw bad_argument("shapes", fmt::format("'{}' is only in memory; save it as a file first", source.file));
    return "\n[[shape]]\n" + text_of(source, shape_settings()) + text_of(source.placement, place_settings());
}

/// What a project cannot have beside what it plays, because that has its own.
void check_subject(const Project& project, const Section& whole, const std::string& where) {
    if (project.is_of_shapes() && project.shapes.empty())
        throw bad_input(where, "it has no [[shape]]; add one with a 'file' or the 'kind' of a built-in shape");
    if (project.hand && !project.path.empty())
        throw bad_input(whole.at("path"), "path and [hand] both say what is played; keep one");
    for (const Setting& one : project_settings())
        if (whole.find(one.key) != nullptr)
            if (const std::string why = why_idle(one.key, project); !why.empty())
                throw bad_input(whole.at(one.key), fmt::format("{} {}", one.key, why));
}

}  // namespace

Project project_from_toml(std::string_view text, const std::string& where) {
    const toml::table root = section::parse_text(text, where);
    const Section whole(where, root);
    require_known(whole, {"format"}, project_settings());
    const auto format = whole.required(whole.text("format"), "format", fmt::format("\"{}\"", format_name));
    if (format != format_name)
        throw whole.wrong(*whole.find("format"), "format", fmt::format("\"{}\" for this version", format_name));
    Project project;
    read_settings(project, whole, project_settings());
    const Section place(where, root, "place");
    require_known(place, {}, place_settings());
    read_settings(project.placement, place, place_settings());
    read_tables(project.shapes, root, where, "shape", "shapes", read_shape);
    read_tables(project.key_frames, root, where, "keyframe", "key frames",
                [&](const Section& frame, const std::string&) { return read_key_frame(frame, project.shapes.size()); });
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
    std::string text = fmt::format("format = \"{}\"\n", format_name) + text_of(project, project_settings());
    if (project.hand)
        text +=
            "\n[hand]\n" + text_of(*project.hand, hand_settings()) + text_of(project.hand->object, object_settings());
    const std::string placed = text_of(project.placement, place_settings());
    if (!placed.empty()) text += "\n[place]\n" + placed;
    for (const ShapeSource& shape : project.shapes) text += to_toml(shape);
    for (const KeyFrame& frame : project.key_frames) text += "\n[[keyframe]]\n" + text_of(frame, key_frame_settings());
    return text + to_toml(project.triggers) + to_toml(project.live);
}

bool is_project(const std::string& path) { return path.ends_with(".toml") || is_bundle(path); }

}  // namespace haptogram
