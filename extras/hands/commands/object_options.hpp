// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <string>

#include "haptogram/verbs/hand_source.hpp"
#include "setting_options.hpp"

namespace haptogram::cli {

/// The solid that hands feel, as a command line names it.
struct ObjectArguments {
    std::string name;
    Given<ObjectSource> given{};
};

/// An option for a length in mm, which is metres inside.
void add_mm(CLI::App& command, const std::string& name, double& metres, const std::string& about);

/// What an object can be, in words.
[[nodiscard]] std::string object_words();
/// @throws Error{bad_argument} for options that this object does not have
[[nodiscard]] ObjectSource object_of(const ObjectArguments& object);

}  // namespace haptogram::cli
