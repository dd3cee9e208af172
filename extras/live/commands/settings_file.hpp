// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace haptogram::cli {

/// Options of `haptogram live` that the table [live] of a project gives. What the command line gives stays, also
/// against what it excludes.
/// @throws Error{bad_input} naming the file, the line and the key
void take_live_table(CLI::App& command, const std::string& file);

}  // namespace haptogram::cli
