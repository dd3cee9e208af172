// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <numeric>
#include <regex>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/bundle.hpp"

namespace haptogram::cli {
namespace {

struct Group {
    Purpose purpose;
    const char* what;
    std::vector<AddCommand> commands;
};

/// Every command of the core, by what a person wants, in the order of --help. Those of extras come behind them.
const Group groups[] = {
    {Purpose::make, "Make what is to be felt", {add_compile, add_solve}},
    {Purpose::measure, "See and measure it before it plays", {add_inspect, add_field, add_analyze, add_report}},
    {Purpose::play,
     "Play it on a board",
     {add_device, add_upload, add_download, add_play, add_stream, add_board, add_bitstream}},
    {Purpose::hands, "Hands in the loop", {}},
    {Purpose::other, "From other programs", {add_completion}},
};

/// What a command ends with; scripts rely on it.
int exit_code(ErrorCode code) {
    switch (code) {
        case ErrorCode::failed: return 1;
        case ErrorCode::bad_argument: return 2;
        case ErrorCode::bad_input: return 3;
        case ErrorCode::device: return 4;
        case ErrorCode::cancelled: return 1;
    }
    return 1;
}

/// The command that was called.
const CLI::App& called(const CLI::App& app) {
    const CLI::App* command = &app;
    while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
    return *command;
}

/// As it is typed: "haptogram board power".
std::string typed(const CLI::App& command) {
    const CLI::App* above = command.get_parent();
    return (above == nullptr ? std::string() : typed(*above) + " ") + command.get_name();
}

/// The option of the command that was called which sets what the library calls `setting`; empty when there is none.
std::string option_of(const CLI::App& app, const std::string& setting) {
    std::string name = "--" + setting;
    std::replace(name.begin(), name.end(), '_', '-');
    for (const CLI::Option* option : called(app).get_options())
        if (option->check_lname(name.substr(2))) return name;
    return {};
}

/// The library's error in the words of the command line: settings become options.
std::string message_of(const CLI::App& app, const Error& error) {
    const std::string option = error.names_setting() ? option_of(app, error.where()) : std::string();
    std::string message = option.empty() ? error.what() : fmt::format("{}: {}", option, error.message());
    std::vector<std::string> remedies;
    for (const std::string& remedy : error.remedies())
        if (std::string name = option_of(app, remedy); !name.empty()) remedies.push_back(std::move(name));
    if (!remedies.empty()) message += fmt::format(" ({})", fmt::join(remedies, ", "));
    return message;
}

/// Whether what reads standard output has gone, as head does when it has seen enough.
bool reader_is_gone() {
    pollfd out{STDOUT_FILENO, 0, 0};
    return ::poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0;
}

/// Then there is nobody to tell; but a compiler's other files are missing, too.
void end_quietly(const CLI::App& app) {
    if (!reader_is_gone() || app.got_subcommand("compile")) return;
    std::signal(SIGPIPE, SIG_DFL);
    std::raise(SIGPIPE);
}

/// How many letters must be added, dropped or replaced to make one word of another.
std::size_t letters_between(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t corner = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = corner + (a[i] == b[j] ? 0 : 1);
            corner = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

/// What is said of words that nothing takes: CLI11 would only say that a subcommand is missing.
Error not_taken(const CLI::App& app) {
    const CLI::App& command = called(app);
    const std::vector<std::string> left = app.remaining(true);
    const auto odd = std::ranges::find_if(left, [](const std::string& word) { return word.starts_with("-"); });
    const bool is_option = odd != left.end(), is_command = !is_option && !command.get_subcommands({}).empty();
    const std::string word = is_option ? odd->substr(0, odd->find('=')) : left.front();
    std::vector<std::string> names;
    if (is_command)
        for (const CLI::App* next : command.get_subcommands({})) names.push_back(next->get_name());
    if (is_option)
        for (const CLI::Option* option : command.get_options())
            for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    std::string nearest;
    std::size_t least = 3;
    for (const std::string& name : names)
        if (const std::size_t letters = letters_between(word, name); letters < std::min(least, word.size())) {
            least = letters;
            nearest = name;
        }
    std::string message = fmt::format("{} of {}",
                                      is_option    ? "is no option"
                                      : is_command ? "is no command"
                                                   : "comes after the last argument",
                                      typed(command));
    if (!nearest.empty()) message += fmt::format("; did you mean {}?", nearest);
    if (&command == &app && !extras_left_out().empty())
        message += fmt::format("; this build leaves out {}", extras_left_out());
    return bad_argument(word, fmt::format("{}; see {} --help", message, typed(command)));
}

/// What CLI11 says of wrong usage, in the words of this program.
std::string in_plain_words(const std::string& text) {
    static const std::regex together("(\\S+) excludes (\\S+)"), no_number("Could not convert: (\\S+) = (.*)"),
        no_choice("(\\S+): (.*) not in \\{(.*)\\}"), none("(\\S+): (\\d+) required \\S+ missing"),
        few("(\\S+): At least (\\d+) required but received (\\d+)"), needed("(\\S+) is required"), comma(",");
    std::smatch part;
    if (std::regex_match(text, part, together)) {
        const bool has_spaces = part.str(1) == "source" && part.str(2) == "--focus";
        return fmt::format("{} and {} cannot be given together{}", part.str(1), part.str(2),
                           has_spaces ? "; a focus is x,y,z without spaces" : "");
    }
    if (std::regex_match(text, part, no_number))
        return fmt::format("{}: found '{}', expected a number", part.str(1), part.str(2));
    if (std::regex_match(text, part, no_choice))
        return fmt::format("{}: found '{}', expected one of {}", part.str(1), part.str(2),
                           std::regex_replace(part.str(3), comma, ", "));
    if (std::regex_match(text, part, none))
        return fmt::format("{}: found no value, expected {}", part.str(1), part.str(2));
    if (std::regex_match(text, part, few))
        return fmt::format("{}: found {}, expected {} values", part.str(1), part.str(3), part.str(2));
    if (std::regex_match(text, part, needed)) return fmt::format("{}: is missing", part.str(1));
    return text;
}

/// Runs `work`; an exception becomes a line on stderr and an exit code.
template <class Work>
int guarded(const CLI::App& app, Work work) {
    const auto fail = [](const std::string& message, ErrorCode code) {
        complain(message);
        return exit_code(code);
    };
    try {
        const int code = work();
        std::cout.flush();
        if (!std::cout || std::fflush(stdout) != 0) {
            const int reason = errno;
            end_quietly(app);
            return fail(fmt::format("standard output: {}; what was printed is incomplete",
                                    std::generic_category().message(reason)),
                        ErrorCode::bad_input);
        }
        return code;
    } catch (const Error& error) {
        if (error.where() == "-") end_quietly(app);
        return fail(message_of(app, error), error.code());
    } catch (const std::bad_alloc&) {
        return fail("out of memory; take fewer points or a coarser step", ErrorCode::failed);
    } catch (const std::system_error& error) {  // from {fmt}, when printing fails
        end_quietly(app);
        return fail(fmt::format("standard output: {}; what was printed is incomplete", error.what()),
                    ErrorCode::bad_input);
    } catch (const std::exception& error) {
        return fail(error.what(), ErrorCode::failed);
    }
}

int parse_and_act(CLI::App& app, const Action& action, int argc, char** argv) {
    try {
        app.parse(argc, argv);
    } catch (const CLI::ExtrasError&) {
        throw not_taken(app);
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        complain(fmt::format("{}; see {} --help", in_plain_words(error.what()), typed(called(app))));
        return exit_code(ErrorCode::bad_argument);
    }
    if (action) return action();
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    complain(fmt::format("expected a command: {}; see haptogram --help", fmt::join(names, ", ")));
    return exit_code(ErrorCode::bad_argument);
}

int run(int argc, char** argv) {
    CLI::App app(
        "Mid-air tactile shapes by focused ultrasound: compile shapes to images, simulate the FPGA that plays them.",
        "haptogram");
    app.set_version_flag("--version", about_this_build());
    app.footer(
        "Numbers may carry their unit: 4cm, 7Hz, 12V.\nExit codes: 0 ok, 1 run failed, 2 usage, 3 bad input, 4 device "
        "or link.");
    Action action;
    for (const Group& group : groups) {
        std::vector<AddCommand> commands = group.commands;
        if (const auto more = extras().commands.find(group.purpose); more != extras().commands.end())
            commands.insert(commands.end(), more->second.begin(), more->second.end());
        for (const AddCommand add : commands) {
            add(app, action);
            app.get_subcommands({}).back()->group(group.what);
        }
    }
    accept_units(app);
    return guarded(app, [&] { return parse_and_act(app, action, argc, argv); });
}

}  // namespace
}  // namespace haptogram::cli

int main(int argc, char** argv) {
    // A file that is opened must never become standard error: messages would end up in it.
    for (int opened = 0; opened >= 0 && opened <= STDERR_FILENO;) {
        opened = ::open("/dev/null", O_RDONLY);  // so that data written to a closed standard output are missed
        if (opened > STDERR_FILENO) ::close(opened);
    }
    // Without these two lines, writing to a closed pipe or beyond a limit of file size would end the program without a
    // message.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    return haptogram::cli::run(argc, argv);
}
