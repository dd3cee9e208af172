// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/settings_table.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"
#include "haptogram/base/toml_section.hpp"

namespace haptogram::live {
namespace {

std::string text_of(const toml::node& node) {
    if (const auto* text = node.as_string()) return text->get();
    const toml::array* list = node.as_array();
    if (list == nullptr) return section::found(node);
    std::vector<std::string> parts;
    for (const toml::node& part : *list) parts.push_back(section::found(part));
    return fmt::format("{}", fmt::join(parts, ","));
}

}  // namespace

std::vector<TableEntry> settings_table(const std::string& file, const std::string& table) {
    const toml::table root = section::parse(file);
    const toml::table* settings = root[table].as_table();
    if (settings == nullptr) throw bad_input(file, fmt::format("it has no table [{}]", table));
    std::vector<TableEntry> entries;
    for (const auto& [key, value] : *settings)
        entries.push_back({std::string(key.str()), text_of(value), section::place(file, value)});
    return entries;
}

}  // namespace haptogram::live
