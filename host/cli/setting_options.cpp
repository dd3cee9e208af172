// SPDX-License-Identifier: Apache-2.0
#include "setting_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "command.hpp"

namespace haptogram::cli {

CLI::Option* add_setting(CLI::App& command, const SettingText& setting, const std::optional<SettingValue>& standard,
                         const std::function<void(const SettingValue&)>& take) {
    const std::string name(setting.option), help(setting.help);
    const auto& kind = setting.kind;
    CLI::Option* option = nullptr;
    if (std::holds_alternative<Flag>(kind))
        return command.add_flag_function(
            name, [take](std::int64_t) { take(true); }, help);
    if (std::holds_alternative<Numbers>(kind) || std::holds_alternative<Length>(kind)) {
        const Numbers* numbers = std::get_if<Numbers>(&kind);
        option = command.add_option_function<double>(name, take, help);
        option->check(numbers != nullptr ? number(numbers->least, numbers->most)
                                         : number(Length::least_mm, Length::most_mm));
    } else if (const auto* whole_numbers = std::get_if<WholeNumbers>(&kind)) {
        option = command.add_option_function<std::uint64_t>(name, take, help);
        option->check(whole(whole_numbers->least, whole_numbers->most));
    } else if (std::holds_alternative<Place>(kind) || std::holds_alternative<Turn>(kind)) {
        option = command.add_option_function<std::vector<double>>(
            name,
            [take](const std::vector<double>& three) {
                take(std::array{three[0], three[1], three[2]});
            },
            help);
        const double most = std::holds_alternative<Place>(kind) ? Place::most_mm : Turn::most_deg;
        option->delimiter(',')->expected(3)->check(number(-most, most));
    } else {
        option = command.add_option_function<std::string>(name, take, help);
        if (const auto* names = std::get_if<Choices>(&kind))
            option->check(CLI::IsMember(std::vector<std::string>(names->begin(), names->end())));
        else if (const auto* form = std::get_if<Form>(&kind))
            option->check(CLI::Validator(
                [form](const std::string& text) {
                    return form->fits(text) ? "" : fmt::format("found '{}', expected {}", text, form->expected);
                },
                "TEXT"));
    }
    if (standard) option->default_str(option_text(*standard));
    return option;
}

}  // namespace haptogram::cli
