// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <string_view>

#include "haptogram/verbs/project.hpp"

namespace haptogram {

/// A setting that not everything can have, and what can have it. It stands here once, for command lines and project
/// files: what has no effect on what is given is refused and named.
struct Setting {
    std::string_view option;          ///< on a command line
    std::string_view key;             ///< in a project file; none: it is not there, or inside a table that has it alone
    bool (*applies)(const Project&);  ///< whether it has an effect on this project
    std::string_view subject;         ///< what it is of, in words
};

/// Settings of `haptogram compile` and of project files. Any other applies to everything.
[[nodiscard]] std::span<const Setting> project_settings();

/// Why a project cannot have a setting; empty when it can, or when the setting is not in project_settings().
/// @param name  an option or a key
[[nodiscard]] std::string why_idle(std::string_view name, const Project& project);

/// @param given  options of a command line
/// @throws Error{bad_argument} naming the first that has no effect
void require_effect(std::span<const std::string> given, const Project& project);

}  // namespace haptogram
