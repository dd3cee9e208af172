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
#include <map>
#include <regex>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

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
            throw bad_argument(std::string(one.option), fmt::format("has no effect, because {} is {}; it belongs to {}",
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

namespace {

/// A number that `fits`. @param expected  in words
template <class Fits>
CLI::Validator number_that(Fits fits, std::string expected) {
    return {[fits, expected = std::move(expected)](std::string& text) {
                double value = 0.0;
                if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) && fits(value)) return std::string();
                return fmt::format("found '{}', expected {}", text, expected);
            },
            "NUMBER"};
}

struct Unit {
    std::string_view name;
    double of_the_option;  ///< one of it, in the unit that the option's help names
};

/// Units that a value of an option may carry, by that which its help names.
const std::map<std::string_view, std::vector<Unit>> units = {
    {"mm", {{"mm", 1}, {"cm", 10}, {"m", 1000}, {"um", 1e-3}, {"µm", 1e-3}, {"in", 25.4}, {"inch", 25.4}}},
    {"Hz", {{"Hz", 1}, {"kHz", 1e3}, {"MHz", 1e6}}},
    {"s", {{"s", 1}, {"ms", 1e-3}, {"min", 60}}},
    {"ms", {{"ms", 1}, {"s", 1e3}}},
    {"V", {{"V", 1}, {"mV", 1e-3}}},
    {"N", {{"N", 1}, {"mN", 1e-3}}},
    {"degrees", {{"degrees", 1}, {"deg", 1}, {"°", 1}}},
};

/// Of a number with one of these units, only the number, in the option's unit. Other text stays, for the check.
CLI::Validator in_unit(const std::vector<Unit>& known) {
    return {[&known](std::string& text) {
                const std::size_t digits = text.find_last_of("0123456789.") + 1;
                const std::size_t begins = std::min(text.find_first_not_of(' ', digits), text.size());
                const auto unit = std::ranges::find(known, std::string_view(text).substr(begins), &Unit::name);
                double value = 0.0;
                if (unit != known.end() && CLI::detail::lexical_cast(text.substr(0, digits), value))
                    text = fmt::format("{:.15g}", value * unit->of_the_option);
                return std::string();
            },
            ""};
}

}  // namespace

void accept_units(CLI::App& app) {
    // Where a help ends, or a part of it does; not in "flat disc of 20 mm, and", "N s/m" or "mm/s".
    static const std::regex named("(?:,| many| in) (mm|Hz|degrees|s|ms|V|N)(?:$|[,;:]| \\([^)]*\\)$)");
    for (CLI::Option* option : app.get_options()) {
        std::smatch unit;
        const std::string& help = option->get_description();
        const bool is_number = option->get_type_name().starts_with("FLOAT") && option->get_expected_max() == 1;
        if (!is_number || !std::regex_search(help, unit, named)) continue;
        option->transform(in_unit(units.at(unit.str(1))));
    }
    for (CLI::App* command : app.get_subcommands({})) accept_units(*command);
}

CLI::Validator positive() {
    return number_that([](double value) { return value > 0.0; }, "a number above 0");
}

CLI::Validator not_negative() {
    return number_that([](double value) { return value >= 0.0; }, "a number of 0 or more");
}

CLI::Validator number(double low, double high) {
    return number_that([low, high](double value) { return value >= low && value <= high; },
                       fmt::format("a number from {} to {}", low, high));
}

CLI::Validator whole(std::uint64_t low, std::uint64_t high) {
    return {[low, high](std::string& text) {
                std::uint64_t value = 0;
                const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
                if (error == std::errc() && end == text.data() + text.size() && value >= low && value <= high)
                    return std::string();
                return fmt::format("found '{}', expected a whole number from {} to {}", text, low, high);
            },
            "WHOLE"};
}

}  // namespace haptogram::cli
