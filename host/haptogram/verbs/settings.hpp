// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "haptogram/verbs/project.hpp"

namespace haptogram {

struct Flag {};
struct File {};        ///< the name of one
struct FileOrName {};  ///< the name of one, or that of something shipped, or of a waveform
struct Numbers {
    double least, most;
};
struct WholeNumbers {
    std::uint64_t least, most;
};
struct Form {
    bool (*fits)(std::string_view);
    std::string_view expected;  ///< in words
    std::string_view pattern;   ///< the same as a regular expression
};
using Choices = std::span<const std::string_view>;
struct OwnTable {};  ///< a table of the project file, with a reader of its own, or an option of such a table

using SettingValue = std::variant<bool, std::uint64_t, double, std::string>;

/// A setting of a project. What the command line, the project file and its schema say of it stands here once. A setting
/// that not everything can have says what can: where it has no effect it is refused.
struct Setting {
    std::string_view key;       ///< in a project file; none: an option of a table that has it alone
    std::string_view option{};  ///< of haptogram compile; none: it has options of its own, or is in files alone
    std::string_view help{};    ///< a sentence without its full stop
    std::variant<Flag, File, FileOrName, Numbers, WholeNumbers, Form, Choices, OwnTable> kind = OwnTable{};
    std::string_view one_of{};  ///< what it says, when another setting can say it instead: a project has one of them
    bool (*applies)(const Project&) = nullptr;  ///< whether it has an effect; none: it always has
    std::string_view subject{};                 ///< what it is of, in words
    std::optional<SettingValue> (*get)(const Project&, const Setting&) = nullptr;  ///< nothing: it is not said
    void (*put)(Project&, const Setting&, const SettingValue&) = nullptr;
};

/// In the order in which a project file has them.
[[nodiscard]] std::span<const Setting> project_settings();

/// @param name  an option or a key
/// @throws Error{bad_argument} when there is none
[[nodiscard]] const Setting& setting_called(std::string_view name);

/// What a project has that says nothing of it.
[[nodiscard]] std::optional<SettingValue> default_of(const Setting& setting);

/// Why a project cannot have a setting; empty when it can, or when there is no such setting.
/// @param name  an option or a key
[[nodiscard]] std::string why_idle(std::string_view name, const Project& project);

/// @param given  options of a command line
/// @throws Error{bad_argument} naming the first that has no effect
void require_effect(std::span<const std::string> given, const Project& project);

}  // namespace haptogram
