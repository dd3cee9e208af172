// SPDX-License-Identifier: Apache-2.0
#include "settings_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/live_table.hpp"

namespace haptogram::cli {
namespace {

/// An option that was given and excludes this one.
const CLI::Option* rival_of(const CLI::Option& option) {
    const auto& rivals = option.get_excludes();
    const auto given = std::ranges::find_if(rivals, [](const CLI::Option* rival) { return rival->count() > 0; });
    return given == rivals.end() ? nullptr : *given;
}

void take(CLI::Option& option, const LiveSetting& setting) {
    try {
        if (option.get_items_expected_max() > 1)
            option.add_result(setting.parts);
        else
            option.add_result(fmt::format("{}", fmt::join(setting.parts, ",")));
        option.run_callback();
    } catch (const CLI::Error& error) {
        throw bad_input(setting.where, error.what());
    }
}

}  // namespace

void take_live_table(CLI::App& command, const std::string& file) {
    const std::vector<std::string> given = given_to(command);
    for (const LiveSetting& setting : load_live_table(file)) {
        std::string name = fmt::format("--{}", setting.key);
        std::replace(name.begin(), name.end(), '_', '-');
        CLI::Option* option = command.get_option_no_throw(name);
        if (option == nullptr || !option->get_configurable())
            throw bad_input(setting.where,
                            fmt::format("unknown key live.{}; known are the options that 'haptogram live "
                                        "--help' names, with _ for -",
                                        setting.key));
        if (option->count() > 0) continue;
        if (const CLI::Option* rival = rival_of(*option); rival == nullptr)
            take(*option, setting);
        else if (!is_among(given, rival->get_name()))
            throw bad_input(setting.where, fmt::format("{} and {} exclude each other; keep one", setting.key,
                                                       rival->get_name().substr(2)));
    }
}

}  // namespace haptogram::cli
