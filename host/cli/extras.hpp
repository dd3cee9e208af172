// SPDX-License-Identifier: Apache-2.0
// What the program gets from outside of the core: the simulated boards, and the extras (extras/README.md). Each has one
// function register_NAME(Extras&), and extras.cpp, which CMake writes, calls those that are linked.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"
#include "haptogram/verbs/path_makers.hpp"
#include "haptogram/verbs/timeline.hpp"

namespace haptogram::cli {

/// What a person wants of a command, in the order of --help.
enum class Purpose { make, measure, play, hands, other };

struct Extras {
    std::map<Purpose, std::vector<AddCommand>> commands{};   ///< behind those of the core
    std::map<std::string, std::vector<AddCommand>> below{};  ///< subcommands of a command of the core, by its name
    PathMakers makers{};                                     ///< for whatever compiles
    /// Whether a hand is expected to feel what plays, as one sentence; `advises`: with the options of compile that
    /// would help a shape. Empty without the extra that knows.
    std::function<std::string(const Timeline&, bool advises)> verdict{};
};

/// Those of this program, registered.
[[nodiscard]] const Extras& extras();

/// Adds the subcommands that extras have for a command of the core.
void add_below(const std::string& name, CLI::App& command, Action& action);

/// In extras.cpp: calls register_NAME() of all that are linked, and names those that are not.
void register_extras(Extras& extras);
[[nodiscard]] std::string_view extras_left_out();

}  // namespace haptogram::cli
