// SPDX-License-Identifier: Apache-2.0
#include "settings_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/live/settings_table.hpp"

namespace haptogram::cli {

void take_settings(CLI::App& command, const std::string& file, const std::string& table) {
    for (const live::TableEntry& entry : live::settings_table(file, table)) {
        std::string name = fmt::format("--{}", entry.key);
        std::replace(name.begin(), name.end(), '_', '-');
        CLI::Option* option = command.get_option_no_throw(name);
        if (option == nullptr)
            throw bad_input(entry.where, fmt::format("found {}, expected the name of an option of '{}', with _ for -",
                                                     entry.key, command.get_name()));
        if (option->count() > 0) continue;
        try {
            option->add_result(entry.value);
            option->run_callback();
        } catch (const CLI::Error& error) {
            throw bad_input(entry.where, error.what());
        }
    }
}

}  // namespace haptogram::cli
