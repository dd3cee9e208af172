// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/live_table.hpp"

#include <fmt/format.h>

#include "haptogram/base/file.hpp"
#include "haptogram/base/toml_section.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram {
namespace {

constexpr std::string_view table_name = "live";

/// Adds one value to a setting. @return it as the file has it
std::string add_part(LiveSetting& setting, const toml::node& node, const section::Section& section) {
    if (const auto* text = node.as_string()) {
        setting.parts.push_back(text->get());
        return section::quoted_text(text->get());
    }
    if (!node.is_number() && !node.is_boolean())
        throw section.wrong(node, setting.key,
                            "a text in quotes, a number, true or false, or a list of texts or "
                            "numbers");
    setting.parts.push_back(section::found(node));
    return setting.parts.back();
}

std::vector<LiveSetting> settings_of(const toml::table& root, const std::string& where) {
    const section::Section section(where, root, std::string(table_name));
    std::vector<LiveSetting> settings;
    const toml::table* table = root.get_as<toml::table>(table_name);
    if (table == nullptr) return settings;
    for (const auto& [name, value] : *table) {
        const std::string_view key = name.str();
        const toml::node* const node = section.find(key);
        LiveSetting& setting = settings.emplace_back();
        setting.key = key;
        setting.where = section.at(key);
        const toml::array* list = node->as_array();
        if (list == nullptr) {
            setting.toml = add_part(setting, *node, section);
            continue;
        }
        if (list->empty()) throw section.wrong(*node, key, "a list that has something in it");
        for (const toml::node& part : *list)
            setting.toml += (setting.toml.empty() ? "" : ", ") + add_part(setting, part, section);
        setting.toml = "[" + setting.toml + "]";
    }
    return settings;
}

}  // namespace

std::vector<LiveSetting> load_live_table(const std::string& path) {
    const std::string file = project_file(path).string();
    std::vector<LiveSetting> settings = live_table_from_toml(read_file(file), file);
    if (settings.empty()) throw bad_input(file, fmt::format("it has no table [{}]", table_name));
    return settings;
}

std::vector<LiveSetting> live_table_from_toml(std::string_view text, const std::string& where) {
    return settings_of(section::parse_text(text, where), where);
}

std::string to_toml(std::span<const LiveSetting> settings) {
    std::string text;
    for (const LiveSetting& setting : settings)
        text += fmt::format("{}{} = {}\n", text.empty() ? fmt::format("\n[{}]\n", table_name) : "", setting.key,
                            setting.toml);
    return text;
}

}  // namespace haptogram
