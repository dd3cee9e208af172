// SPDX-License-Identifier: Apache-2.0
#include "command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "haptogram/base/error.hpp"
#include "haptogram/base/notice.hpp"
#include "haptogram/solve/segments.hpp"
#include "haptogram/verbs/settings.hpp"

namespace haptogram::cli {

void complain(const std::string& message) {
    // A reader that stalls must not keep a board's outputs on. It is waited for once.
    static std::atomic<bool> stalls = false;
    const std::string line = fmt::format("haptogram: {}\n", printable(message));
    stalls = write_within(STDERR_FILENO, line, std::chrono::milliseconds(stalls ? 0 : 100)) < line.size();
}

void require_distinct(const std::vector<NamedPath>& inputs, const std::vector<NamedPath>& outputs) {
    const auto same = [](const std::string& a, const std::string& b) {
        std::error_code error;  // of files that do not exist yet
        const auto place = [&error](const std::string& path) {
            return std::filesystem::weakly_canonical(std::filesystem::absolute(path, error), error);
        };
        return a == b || place(a) == place(b) || std::filesystem::equivalent(a, b, error);
    };
    const auto clash = [](const NamedPath& a, const NamedPath& b) {
        if (!b.of.empty())
            return Error(ErrorCode::bad_argument, b.option,
                         fmt::format("the manifest of {} would be written over {}, which is already {}; give --output "
                                     "another name{}",
                                     b.of, b.path, a.option,
                                     b.option == "--manifest" ? ", or name the manifest with --manifest" : ""));
        return Error(ErrorCode::bad_argument, b.option,
                     fmt::format("{} is already {}; give each its own file", b.path == "-" ? "standard output" : b.path,
                                 a.option));
    };
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        for (const NamedPath& input : inputs)
            if (outputs[i].path != "-" && same(input.path, outputs[i].path)) throw clash(input, outputs[i]);
        for (std::size_t j = 0; j < i; ++j)
            if (same(outputs[j].path, outputs[i].path)) throw clash(outputs[j], outputs[i]);
    }
}

std::vector<std::string> given_to(const CLI::App& command) {
    std::vector<std::string> given;
    for (const CLI::Option* option : command.get_options())
        if (option->count() > 0) given.push_back(option->get_name());
    return given;
}

bool is_among(const std::vector<std::string>& given, std::string_view option) {
    return std::ranges::find(given, option) != given.end();
}

void require_effect(const std::vector<std::string>& given, const std::vector<OptionOf>& options, std::string_view kind,
                    std::string_view subject) {
    for (const OptionOf& one : options)
        if (is_among(given, one.option) && std::ranges::find(one.kinds, kind) == one.kinds.end())
            throw bad_argument(std::string(one.option), fmt::format("has no effect, because {} is {}; it is of {}",
                                                                    subject, kind, fmt::join(one.kinds, ", ")));
}

void add_am(CLI::App& command, std::optional<std::string>& am, std::optional<std::string>& law) {
    auto* wave = command.add_option("--am", am, std::string(setting_called("--am").help));
    command.add_option("--am-law", law, std::string(setting_called("--am-law").help))
        ->check(CLI::IsMember({"pressure", "radiation"}))
        ->default_str("pressure")
        ->needs(wave);
}

CLI::Option* add_quantise(CLI::App& command, std::optional<std::string>& quantise) {
    return command.add_option("--quantise", quantise, std::string(setting_called("--quantise").help))
        ->check(CLI::IsMember({hoshi_segments.name}));
}

AmplitudeLaw law_of(const std::string& name) {
    return name == "radiation" ? AmplitudeLaw::radiation : AmplitudeLaw::pressure;
}

void add_number(CLI::App& command, const std::string& name, double& value, const std::string& about) {
    command.add_option(name, value, about)->check(positive())->capture_default_str();
}

CLI::Validator positive() {
    return {[](std::string& text) {
                double value = 0.0;
                if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0.0) return std::string();
                return fmt::format("must be a positive number, found '{}'", text);
            },
            "POSITIVE"};
}

CLI::Validator not_negative() {
    return {[](std::string& text) {
                double value = 0.0;
                if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= 0.0)
                    return std::string();
                return fmt::format("must be a number, and not negative, found '{}'", text);
            },
            "NUMBER"};
}

CLI::Validator number(double low, double high) {
    return {[low, high](std::string& text) {
                double value = 0.0;
                if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return std::string();
                return fmt::format("must be a number from {} to {}, found '{}'", low, high, text);
            },
            "NUMBER"};
}

CLI::Validator whole(std::uint64_t low, std::uint64_t high) {
    return {[low, high](std::string& text) {
                std::uint64_t value = 0;
                const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
                if (error == std::errc() && end == text.data() + text.size() && value >= low && value <= high)
                    return std::string();
                return fmt::format("must be a whole number from {} to {}, found '{}'", low, high, text);
            },
            "WHOLE"};
}

}  // namespace haptogram::cli
