// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/document.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>

#include "haptogram/base/error.hpp"
#include "haptogram/base/toml_value.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram {
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
