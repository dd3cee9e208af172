// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/format/waveform.hpp"
#include "haptogram/verbs/path_makers.hpp"

namespace haptogram::cli {

/// What a subcommand does once the command line has been read; returns the exit code.
using Action = std::function<int()>;

/// Adds a subcommand to `app`, and puts what it does into `action` when it is the one that was called.
using AddCommand = void (*)(CLI::App& app, Action& action);

// Those of the core.
void add_compile(CLI::App& app, Action& action);
void add_inspect(CLI::App& app, Action& action);
void add_field(CLI::App& app, Action& action);
void add_solve(CLI::App& app, Action& action);
void add_analyze(CLI::App& app, Action& action);
void add_report(CLI::App& app, Action& action);
void add_board(CLI::App& app, Action& action);
void add_holder(CLI::App& board, Action& action);
void add_device(CLI::App& app, Action& action);
void add_device_list(CLI::App& device, Action& action);
void add_device_trigger(CLI::App& device, Action& action);
void add_self_test(CLI::App& device, Action& action);
void add_upload(CLI::App& app, Action& action);
void add_download(CLI::App& app, Action& action);
void add_play(CLI::App& app, Action& action);
void add_stream(CLI::App& app, Action& action);
void add_completion(CLI::App& app, Action& action);
void add_bitstream(CLI::App& app, Action& action);

/// @return what --version says: the release, the commit of the sources, and what this build has
[[nodiscard]] std::string about_this_build();

/// What makes paths of hands and of magnitudes, as far as this build has it (extras.hpp).
[[nodiscard]] const PathMakers& path_makers();

/// A line on stderr, with the program's name in front; never throws for want of a stderr.
void complain(const std::string& message);

/// A file that an option names.
struct NamedPath {
    std::string option;
    std::string path;
    std::string of = {};  ///< of a manifest that takes its name from it: the image
};

/// @throws Error{bad_argument} when an output would overwrite an input or another output, or two go to standard output
void require_distinct(const std::vector<NamedPath>& inputs, const std::vector<NamedPath>& outputs);

/// Names of the options that were given to a command.
[[nodiscard]] std::vector<std::string> given_to(const CLI::App& command);
[[nodiscard]] bool is_among(const std::vector<std::string>& given, std::string_view option);

/// An option that has an effect on some of the kinds of a command's subject alone.
struct OptionOf {
    std::string_view option;
    std::vector<std::string_view> kinds;
};
/// @throws Error{bad_argument} naming the first of the given options that has no effect on this kind
/// @param subject  what is of that kind: "the movement"
void require_effect(const std::vector<std::string>& given, const std::vector<OptionOf>& options, std::string_view kind,
                    std::string_view subject);

/// The options --am and --am-law.
void add_am(CLI::App& command, std::optional<std::string>& am, std::optional<std::string>& law);
[[nodiscard]] AmplitudeLaw law_of(const std::string& name);

/// The option --quantise.
CLI::Option* add_quantise(CLI::App& command, std::optional<std::string>& quantise);

/// An option for a positive number, whose default is `value`.
void add_number(CLI::App& command, const std::string& name, double& value, const std::string& about);

/// Lets a number carry the unit that its option's help names behind a comma, "many" or "in", or another of the same
/// kind: 4cm, 7 Hz, 12V.
void accept_units(CLI::App& app);

/// Checks of option values that say what was found.
[[nodiscard]] CLI::Validator positive();
[[nodiscard]] CLI::Validator not_negative();
[[nodiscard]] CLI::Validator number(double low, double high);
[[nodiscard]] CLI::Validator whole(std::uint64_t low, std::uint64_t high);

}  // namespace haptogram::cli
