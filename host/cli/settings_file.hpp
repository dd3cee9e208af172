// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace haptogram::cli {

/// Options of a command that a table of a TOML file gives: its keys are their names, with _ for -. What the command
/// line gives stays.
/// @throws Error{bad_input} naming the file and the key
void take_settings(CLI::App& command, const std::string& file, const std::string& table);

}  // namespace haptogram::cli
