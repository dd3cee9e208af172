// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/verbs/settings.hpp"

namespace haptogram::cli {

/// The option of a setting. @param standard  its default
CLI::Option* add_setting(CLI::App& command, const SettingText& setting, const std::optional<SettingValue>& standard,
                         const std::function<void(const SettingValue&)>& take);

/// Settings that a command line has given, in its order.
template <class Owner>
struct Given : std::vector<std::pair<const SettingOf<Owner>*, SettingValue>> {
    void put(Owner& owner) const {
        for (const auto& [setting, value] : *this) setting->put(owner, *setting, value);
    }
    /// @param why  the owner cannot have some, in words
    /// @throws Error{bad_argument} naming the first that has no effect
    void require_effect(const Owner& owner, const std::string& why) const {
        for (const auto& [setting, value] : *this)
            if (!setting->has_effect(owner))
                throw bad_argument(std::string(setting->option),
                                   fmt::format("has no effect, because {}; it is of {}", why, setting->subject));
    }
};

/// The options of a table of settings.
template <class Owner>
void add_settings(CLI::App& command, Settings<Owner> settings, Given<Owner>& given) {
    for (const SettingOf<Owner>& one : settings) {
        if (one.option.empty()) continue;
        CLI::Option* option = add_setting(command, one, default_of(one), [&given, &one](const SettingValue& value) {
            given.emplace_back(&one, value);
        });
        for (const SettingOf<Owner>& other : settings)
            if (!one.one_of.empty() && one.one_of == other.one_of && &other < &one)
                option->excludes(command.get_option(std::string(other.option)));
    }
}

}  // namespace haptogram::cli
