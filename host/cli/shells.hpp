// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <string>

/// What other programs want to know of the command line, made from the options themselves, so that it cannot be out of
/// date.
namespace haptogram::cli {

/// A completion script for a shell. @param shell  "bash", "zsh" or "fish"
[[nodiscard]] std::string completion_script(const CLI::App& app, const std::string& shell);

/// The manual page of the program and all its commands, for man(1).
[[nodiscard]] std::string manual_page(const CLI::App& app);

}  // namespace haptogram::cli
