// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
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
struct Length {  ///< in mm, and metres inside
    static constexpr double least_mm = 1e-6, most_mm = 1e6;
};
struct Place {  ///< x, y and z, likewise
    static constexpr double most_mm = 1e6;
};
struct Turn {  ///< degrees about x, then y, then z
    static constexpr double most_deg = 1e6;
};
struct Form {
    bool (*fits)(std::string_view);
    std::string_view expected;  ///< in words
    std::string_view pattern;   ///< the same as a regular expression
};
using Choices = std::span<const std::string_view>;
struct Table {};  ///< of the project file, with settings of its own

/// As an option or a file has it.
using SettingValue = std::variant<bool, std::uint64_t, double, std::string, std::array<double, 3>>;
/// As an option's word.
[[nodiscard]] std::string option_text(const SettingValue& value);

/// What the command line, the project file and its schema say of a setting.
struct SettingText {
    std::string_view key;       ///< in a project file
    std::string_view option{};  ///< of a command; none: it has options of its own, or is in files alone
    std::string_view help{};    ///< a sentence without its full stop
    std::variant<Flag, File, FileOrName, Numbers, WholeNumbers, Length, Place, Turn, Form, Choices, Table> kind =
        Table{};
    std::string_view needed{};   ///< what it must be, in words, if it must be there
    std::string_view one_of{};   ///< what several settings can say, in words; at most one of these is given
    std::string_view subject{};  ///< what can have the setting, in words; empty: everything
};

/// A setting of a project, or of a part of one. All that there is to say of it stands here once. A setting that not
/// everything can have says what can: where it has no effect it is refused.
template <class Owner>
struct SettingOf : SettingText {
    bool (*applies)(const Owner&) = nullptr;  ///< whether it has an effect; none: it always has
    std::optional<SettingValue> (*get)(const Owner&, const SettingText&) = nullptr;  ///< nothing: it is not said
    void (*put)(Owner&, const SettingText&, const SettingValue&) = nullptr;

    [[nodiscard]] bool has_effect(const Owner& owner) const { return applies == nullptr || applies(owner); }
};
using Setting = SettingOf<Project>;
template <class Owner>
using Settings = std::span<const SettingOf<Owner>>;

/// In the order in which a project file has them.
[[nodiscard]] Settings<Project> project_settings();
[[nodiscard]] Settings<Placement> place_settings();  ///< of a project, and of each shape beside those of shapes
[[nodiscard]] Settings<ShapeSource> shape_settings();
[[nodiscard]] Settings<KeyFrame> key_frame_settings();
[[nodiscard]] Settings<HandSource> hand_settings();
[[nodiscard]] Settings<ObjectSource> object_settings();  ///< which stand beside those of a hand

/// @param name  an option or a key
/// @throws Error{bad_argument} when there is none
[[nodiscard]] const Setting& setting_called(std::string_view name);

/// What its owner has that says nothing of it.
template <class Owner>
[[nodiscard]] std::optional<SettingValue> default_of(const SettingOf<Owner>& setting) {
    static const Owner standard{};
    return setting.get == nullptr ? std::nullopt : setting.get(standard, setting);
}

/// Why a project cannot have a setting; empty when it can, or when there is no such setting.
/// @param name  an option or a key
[[nodiscard]] std::string why_idle(std::string_view name, const Project& project);

/// @param given  options of a command line
/// @throws Error{bad_argument} naming the first that has no effect
void require_effect(std::span<const std::string> given, const Project& project);

}  // namespace haptogram
