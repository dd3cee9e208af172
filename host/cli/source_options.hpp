// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "haptogram/verbs/source.hpp"

namespace haptogram::cli {

/// What a command looks at, as options give it. Every command that looks at something has these.
struct SourceOptions {
    Source source;
    std::string focus;
    std::optional<std::string> quantise;
};

/// The file that a command works on. @param what  it takes, in words, in front of what all of them take
CLI::Option* add_source_file(CLI::App& command, Source& source, const std::string& what = "");
/// The options --array and --board.
void add_array_and_board(CLI::App& command, Source& source);

/// The file, or one of --focus and --pulses, with what belongs to each.
void add_source(CLI::App& command, SourceOptions& options);

/// @throws Error{bad_argument} when a focus is no point, or nothing is given
[[nodiscard]] Source source_of(const SourceOptions& options, const std::string& command);

/// The files that it names, for require_distinct().
[[nodiscard]] std::vector<NamedPath> files_of(const Source& source);

}  // namespace haptogram::cli
