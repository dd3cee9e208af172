// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/document.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptogram/base/error.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/shape/adaptics.hpp"
#include "haptogram/shape/adaptics_frames.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram {
namespace {

constexpr double most_steps = 400.0;                           // each a record, of which the usual core has so many
constexpr double most_of_a_circle = 16.0, least_points = 6.0;  // of a circle, that show its shape
constexpr double most_rate_hz = 1000.0;

}  // namespace

bool is_adaptics(std::string_view text) { return text.find("\"$DATA_FORMAT\"") != std::string_view::npos; }

Project project_from_adaptics(std::string_view text, const std::string& where) {
    AdapticsFrames pattern = frames_from_adaptics(text, where);
    const double lasts_s = pattern.frames.back().time_s;
    Project project;
    ShapeSource shape;
    if (pattern.diameter_m) {
        const double points = std::floor(most_steps / (adaptics_brush_hz * lasts_s));
        if (points < least_points)
            throw bad_input(where, fmt::format("it lasts {:g} s, and {:g} circles a second of {} points each are more "
                                               "than the {} steps that key frames are played in",
                                               lasts_s, adaptics_brush_hz, least_points, most_steps));
        shape.primitive.kind = "circle";
        shape.primitive.diameter = pattern.diameter_m;
        project.pace.frequency_hz = adaptics_brush_hz;
        project.points = static_cast<std::size_t>(std::min(points, most_of_a_circle));
    } else {
        shape.primitive.kind = "point";
        project.points = 1;
        project.rate_hz = std::min(most_steps / lasts_s, most_rate_hz);
    }
    project.shapes.push_back(shape);
    project.placement.center = pattern.centre;
    project.key_frames = std::move(pattern.frames);
    return project;
}

namespace {

using nlohmann::ordered_json;

bool is_bare(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

std::string key_text(const std::string& key) {
    const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), is_bare);
    return bare ? key : section::quoted_text(key);
}

/// Numbers and booleans are written alike in JSON and in TOML, and so are lists of them.
std::string value_text(const std::string& key, const ordered_json& value) {
    if (value.is_array()) {
        std::string text;
        for (const ordered_json& each : value) text += (text.empty() ? "" : ", ") + value_text(key, each);
        return "[" + text + "]";
    }
    if (!value.is_string() && !value.is_number() && !value.is_boolean())
        throw bad_input(key, fmt::format("found {}, which no project file can hold; give text, a number, true, false "
                                         "or a list of these, or leave the key out",
                                         value.is_object() ? "a table within a table" : value.type_name()));
    return value.is_string() ? section::quoted_text(value.get<std::string>()) : value.dump();
}

void write_table(std::string& text, const ordered_json& table) {
    for (const auto& [key, value] : table.items())
        text += fmt::format("{} = {}\n", key_text(key), value_text(key, value));
}

bool is_list_of_tables(const ordered_json& value) {
    return value.is_array() && !value.empty() &&
           std::all_of(value.begin(), value.end(), [](const ordered_json& each) { return each.is_object(); });
}

}  // namespace

ordered_json document_of(std::string_view toml, const std::string& where) {
    (void)project_from_toml(toml, where);  // says in full sentences what is wrong, if anything is
    std::ostringstream text;
    text << toml::json_formatter{toml::parse(toml)};
    return ordered_json::parse(text.str());
}

std::string toml_of(const ordered_json& document) {
    if (!document.is_object())
        throw bad_input("project",
                        fmt::format("found {}, expected a JSON object with a project's keys", document.type_name()));
    std::string values, tables;
    for (const auto& [key, value] : document.items()) {
        if (value.is_object()) {
            tables += fmt::format("\n[{}]\n", key_text(key));
            write_table(tables, value);
        } else if (is_list_of_tables(value)) {
            for (const ordered_json& each : value) {
                tables += fmt::format("\n[[{}]]\n", key_text(key));
                write_table(tables, each);
            }
        } else {
            values += fmt::format("{} = {}\n", key_text(key), value_text(key, value));
        }
    }
    return values + tables;
}

}  // namespace haptogram
