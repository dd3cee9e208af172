// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace haptogram::cli {

/// What a subcommand does once the command line has been read; returns the exit code.
using Action = std::function<int()>;

/// Each adds its subcommand to `app` and puts what it does into `action` when it is the one that was called.
void add_compile(CLI::App& app, Action& action);
void add_inspect(CLI::App& app, Action& action);
void add_simulate(CLI::App& app, Action& action);
void add_field(CLI::App& app, Action& action);

/// The manifest's place beside an image: the same name with ".json".
[[nodiscard]] std::string manifest_path(const std::string& image);

}  // namespace haptogram::cli
