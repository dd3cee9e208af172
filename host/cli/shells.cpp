// SPDX-License-Identifier: Apache-2.0
#include "shells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "command.hpp"
#include "haptogram/format/bundle.hpp"

namespace haptogram::cli {
namespace {

/// One option as a shell sees it.
struct OptionText {
    std::string long_name, short_name;  ///< without dashes; either may be empty
    std::string about;
    bool takes_value = false;
    std::vector<std::string> choices;  ///< of the value, if it must be one of a few
};

/// One command, with the words that lead to it.
struct CommandText {
    std::vector<std::string> path;  ///< after the program's name; empty for the program itself
    std::string about;
    std::vector<OptionText> options;
    std::vector<std::string> operands;  ///< names of what has no option
    std::vector<std::pair<std::string, std::string>> subcommands;
};

/// CLI11 writes the values that an option may have as "{a,b,c}" behind its type.
std::vector<std::string> choices_of(const std::string& type) {
    const std::size_t open = type.find('{'), close = type.find('}');
    std::vector<std::string> found;
    if (open == std::string::npos || close == std::string::npos) return found;
    for (std::size_t at = open + 1; at < close;) {
        const std::size_t end = std::min(type.find(',', at), close);
        found.push_back(type.substr(at, end - at));
        at = end + 1;
    }
    return found;
}

std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

void gather(const CLI::App& app, const std::vector<std::string>& path, std::vector<CommandText>& found) {
    CommandText command{path, one_line(app.get_description()), {}, {}, {}};
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_positional()) {
            command.operands.push_back(option->get_name(true));
            continue;
        }
        OptionText text;
        if (!option->get_lnames().empty()) text.long_name = option->get_lnames().front();
        if (!option->get_snames().empty()) text.short_name = option->get_snames().front();
        text.about = one_line(option->get_description());
        text.takes_value = option->get_expected_max() > 0 && option->get_items_expected_max() > 0;
        text.choices = choices_of(option->get_type_name());
        command.options.push_back(std::move(text));
    }
    const auto subcommands = app.get_subcommands([](const CLI::App*) { return true; });
    for (const CLI::App* sub : subcommands)
        command.subcommands.emplace_back(sub->get_name(), one_line(sub->get_description()));
    found.push_back(std::move(command));
    for (const CLI::App* sub : subcommands) {
        std::vector<std::string> below = path;
        below.push_back(sub->get_name());
        gather(*sub, below, found);
    }
}

std::vector<CommandText> commands_of(const CLI::App& app) {
    std::vector<CommandText> found;
    gather(app, {}, found);
    return found;
}

std::vector<std::string> shell_words_of(const CommandText& command) {
    std::vector<std::string> words;
    for (const auto& [name, about] : command.subcommands) words.push_back(name);
    for (const OptionText& option : command.options) {
        if (!option.long_name.empty()) words.push_back("--" + option.long_name);
        if (!option.short_name.empty()) words.push_back("-" + option.short_name);
    }
    return words;
}

/// For bash and zsh: in single quotes.
std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

constexpr std::string_view note = "# Made by 'haptogram completion'; the program's own options are the source.\n";

std::string bash_script(const std::vector<CommandText>& commands) {
    std::string text = fmt::format("# SPDX-License-Identifier: Apache-2.0\n{}", note);
    text += R"(_haptogram() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} path='' i
    for ((i = 1; i < COMP_CWORD; i++)); do
        case "$path/${COMP_WORDS[i]}" in
)";
    for (const CommandText& command : commands)
        if (!command.path.empty())
            text += fmt::format("            /{0}) path=/{0} ;;\n", fmt::join(command.path, "/"));
    text += "        esac\n    done\n    case \"$path $before\" in\n";
    for (const CommandText& command : commands)
        for (const OptionText& option : command.options)
            if (!option.choices.empty())
                text += fmt::format("        {})\n            COMPREPLY=($(compgen -W {} -- \"$word\")); return ;;\n",
                                    quoted(fmt::format("{}{} --{}", command.path.empty() ? "" : "/",
                                                       fmt::join(command.path, "/"), option.long_name)),
                                    quoted(fmt::format("{}", fmt::join(option.choices, " "))));
    text += "    esac\n    case \"$path\" in\n";
    for (const CommandText& command : commands)
        text += fmt::format("        {}) COMPREPLY=($(compgen -W {} -- \"$word\")) ;;\n",
                            quoted(fmt::format("{}{}", command.path.empty() ? "" : "/", fmt::join(command.path, "/"))),
                            quoted(fmt::format("{}", fmt::join(shell_words_of(command), " "))));
    return text +
           "    esac\n    [[ $word == -* ]] || COMPREPLY+=($(compgen -f -- \"$word\"))\n}\n"
           "complete -o filenames -F _haptogram haptogram\n";
}

std::string zsh_script(const std::vector<CommandText>& commands) {
    std::string text = fmt::format("#compdef haptogram\n# SPDX-License-Identifier: Apache-2.0\n{}", note);
    text += R"(_haptogram() {
    local where='' i
    for ((i = 2; i < CURRENT; i++)); do
        case "$where/${words[i]}" in
)";
    for (const CommandText& command : commands)
        if (!command.path.empty())
            text += fmt::format("            (/{0}) where=/{0} ;;\n", fmt::join(command.path, "/"));
    text += "        esac\n    done\n    local -a found\n    case \"$where ${words[CURRENT-1]}\" in\n";
    for (const CommandText& command : commands)
        for (const OptionText& option : command.options)
            if (!option.choices.empty())
                text += fmt::format("        ({}) compadd -- {}; return ;;\n",
                                    quoted(fmt::format("{}{} --{}", command.path.empty() ? "" : "/",
                                                       fmt::join(command.path, "/"), option.long_name)),
                                    fmt::join(option.choices, " "));
    text += "    esac\n    case \"$where\" in\n";
    const auto entry = [](const std::string& word, std::string about) {
        std::replace(about.begin(), about.end(), ':', ';');  // separates word and description
        return fmt::format("            {}\n", quoted(fmt::format("{}:{}", word, about)));
    };
    for (const CommandText& command : commands) {
        text += fmt::format("        ({})\n            found=(\n",
                            quoted(fmt::format("{}{}", command.path.empty() ? "" : "/", fmt::join(command.path, "/"))));
        for (const auto& [name, about] : command.subcommands) text += entry(name, about);
        for (const OptionText& option : command.options) {
            if (!option.long_name.empty()) text += entry("--" + option.long_name, option.about);
            if (!option.short_name.empty()) text += entry("-" + option.short_name, option.about);
        }
        text += "            ) ;;\n";
    }
    return text + "    esac\n    _describe 'haptogram' found\n    _files\n}\n_haptogram \"$@\"\n";
}

std::string fish_script(const std::vector<CommandText>& commands) {
    const auto fish_quoted = [](const std::string& text) {
        std::string result = "'";
        for (const char c : text) result += c == '\'' || c == '\\' ? fmt::format("\\{}", c) : std::string(1, c);
        return result + "'";
    };
    std::string text = fmt::format("# SPDX-License-Identifier: Apache-2.0\n{}", note);
    text += R"(function __haptogram_at --description 'whether the words so far lead to this command'
    set -l words (commandline -opc)
    set -l path
    for word in $words[2..-1]
        contains -- "$path/$word" $__haptogram_commands; and set path "$path/$word"
    end
    test "$path" = "$argv[1]"
end
)";
    text += "set -g __haptogram_commands";
    for (const CommandText& command : commands)
        if (!command.path.empty()) text += fmt::format(" /{}", fmt::join(command.path, "/"));
    text += "\n";
    for (const CommandText& command : commands) {
        const std::string at =
            fmt::format("-n \"__haptogram_at '{}{}'\"", command.path.empty() ? "" : "/", fmt::join(command.path, "/"));
        for (const auto& [name, about] : command.subcommands)
            text += fmt::format("complete -c haptogram {} -a {} -d {}\n", at, name, fish_quoted(about));
        for (const OptionText& option : command.options) {
            text += fmt::format("complete -c haptogram {}", at);
            if (!option.long_name.empty()) text += fmt::format(" -l {}", option.long_name);
            if (!option.short_name.empty()) text += fmt::format(" -s {}", option.short_name);
            if (!option.choices.empty())
                text += fmt::format(" -x -a {}", fish_quoted(fmt::format("{}", fmt::join(option.choices, " "))));
            else if (option.takes_value)
                text += " -r";
            text += fmt::format(" -d {}\n", fish_quoted(option.about));
        }
    }
    return text;
}

/// Text for roff: backslashes and leading dots have a meaning there, and hyphens of options must stay hyphens.
std::string roff(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '\\')
            result += "\\e";
        else if (c == '-')
            result += "\\-";
        else
            result += c;
    }
    return result.starts_with('.') || result.starts_with('\'') ? "\\&" + result : result;
}

}  // namespace

std::string completion_script(const CLI::App& app, const std::string& shell) {
    const std::vector<CommandText> commands = commands_of(app);
    if (shell == "bash") return bash_script(commands);
    if (shell == "zsh") return zsh_script(commands);
    return fish_script(commands);
}

std::string manual_page(const CLI::App& app) {
    const std::vector<CommandText> commands = commands_of(app);
    std::string text = fmt::format(".TH HAPTOGRAM 1 \"\" \"haptogram {}\"\n.SH NAME\nhaptogram \\- {}\n", version(),
                                   roff(commands.front().about));
    text += ".SH SYNOPSIS\n.B haptogram\n.I COMMAND\n[\\fIOPTION\\fR ...] [\\fIOPERAND\\fR ...]\n.SH COMMANDS\n";
    for (const CommandText& command : commands) {
        if (!command.path.empty()) {
            std::string operands;
            for (const std::string& operand : command.operands) operands += fmt::format(" [\\fI{}\\fR]", roff(operand));
            text +=
                fmt::format(".SS haptogram {}{}\n{}\n", fmt::join(command.path, " "), operands, roff(command.about));
        }
        for (const OptionText& option : command.options) {
            std::string names;
            if (!option.short_name.empty()) names += fmt::format("\\fB\\-{}\\fR", roff(option.short_name));
            if (!option.long_name.empty())
                names += fmt::format("{}\\fB\\-\\-{}\\fR", names.empty() ? "" : ", ", roff(option.long_name));
            std::string value;
            if (!option.choices.empty())
                value = fmt::format(" {{{}}}", roff(fmt::format("{}", fmt::join(option.choices, ", "))));
            else if (option.takes_value)
                value = " \\fIVALUE\\fR";
            text += fmt::format(".TP\n{}{}\n{}\n", names, value, roff(option.about));
        }
    }
    return text + fmt::format(".SH EXIT STATUS\n{}\n", roff(app.get_footer()));
}

namespace {

struct CompletionOptions {
    std::string shell;
};

}  // namespace

void add_completion(CLI::App& app, Action& action) {
    auto options = std::make_shared<CompletionOptions>();
    CLI::App* sub = app.add_subcommand("completion", "Print a completion script for a shell, or the manual page");
    sub->add_option("shell", options->shell, "bash, zsh, fish, or man for the manual page")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish", "man"}));
    sub->callback([options, &app, &action] {
        action = [options, &app] {
            fmt::print("{}", options->shell == "man" ? manual_page(app) : completion_script(app, options->shell));
            return 0;
        };
    });
}

}  // namespace haptogram::cli
