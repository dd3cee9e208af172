// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/verbs/hand_source.hpp"

namespace haptogram::cli {

/// The solid that hands feel, as a command line names it.
struct ObjectArguments {
    std::string name;
    std::optional<double> size_mm{}, height_mm{};
    std::string center = "0,0,200", rotate = "0,0,0", unit = "mm";
};

/// An option for a length in mm, which is metres inside.
void add_mm(CLI::App& command, const std::string& name, double& metres, const std::string& about);

/// What an object can be, in words.
[[nodiscard]] std::string object_words();
/// Adds the options that say how large the object is and where it stands.
void add_object_options(CLI::App& sub, ObjectArguments& object);
/// @throws Error{bad_argument} for numbers that are none, or options that this object does not have
[[nodiscard]] ObjectSource object_of(const ObjectArguments& object, const std::vector<std::string>& given);

}  // namespace haptogram::cli
