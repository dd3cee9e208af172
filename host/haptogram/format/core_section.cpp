// SPDX-License-Identifier: Apache-2.0
#include "haptogram/format/core_section.hpp"

#include <algorithm>
#include <string_view>

namespace haptogram {
namespace {

std::string key_of(std::string_view verilog_name, KeyStyle style) {
    std::string key(verilog_name);
    if (style == KeyStyle::lower_case)
        std::transform(key.begin(), key.end(), key.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return key;
}

}  // namespace

void read_parameters(interface::CoreParameters& parameters, const section::Section& section, KeyStyle style) {
    for (const auto& one : interface::core_parameters)
        section::assign(parameters.*one.member,
                        section.whole(key_of(one.name, style), one.optional ? 0 : one.low, one.high));
    for (const auto& one : interface::core_parameters) {
        if (one.allows(parameters)) continue;
        const std::string key = key_of(one.name, style);
        const std::string expected = fmt::format("{}{}from {} to {}", one.optional ? "0 or " : "",
                                                 one.power_of_two ? "a power of two " : "a whole number ",
                                                 one.lowest(parameters), one.highest(parameters));
        if (const toml::node* node = section.find(key)) throw section.wrong(*node, key, expected);
        throw bad_input(section.at(key), fmt::format("{} must be {} beside the other parameters, and is {}",
                                                     section.full(key), expected, parameters.*one.member));
    }
}

}  // namespace haptogram
