// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <system_error>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/image/manifest.hpp"

namespace haptogram::cli {

std::string manifest_path(const std::string& image) {
    std::filesystem::path path(image);
    return path.replace_extension(".json").string();
}

Manifest manifest_beside(const std::string& image, const std::string& content) {
    const std::string path = manifest_path(image);
    Manifest manifest = manifest_from_json(read_file(path), path);
    if (manifest.image_sha256 != sha256(content))
        throw bad_input(path, fmt::format("it is the manifest of another image than {}; compile that again", image));
    return manifest;
}

void complain(const std::string& message) {
    // Not fmt::print, which throws when stderr is closed.
    std::fputs(fmt::format("haptogram: {}\n", message).c_str(), stderr);
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

namespace {

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

int run(int argc, char** argv) {
    CLI::App app(
        "Mid-air tactile shapes by focused ultrasound: compile shapes to images, simulate the FPGA that plays them.",
        "haptogram");
    app.set_version_flag("--version", "haptogram " + version());
    app.footer("Exit codes: 0 ok, 1 run failed, 2 usage, 3 bad input, 4 device or link.");
    Action action;
    add_compile(app, action);
    add_inspect(app, action);
    add_simulate(app, action);
    add_field(app, action);
    add_analyze(app, action);
    add_board(app, action);
    add_bitstream(app, action);
    add_device(app, action);
    add_upload(app, action);
    add_download(app, action);
    add_play(app, action);
    add_stream(app, action);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ExtrasError& error) {
        // CLI11 would only say that a subcommand is missing.
        throw Error(ErrorCode::bad_argument, "haptogram", fmt::format("{}; see haptogram --help", error.what()));
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : exit_code(ErrorCode::bad_argument);
    }
    if (!action)
        throw Error(
            ErrorCode::bad_argument, "haptogram",
            "expected a subcommand: compile, inspect, simulate, field, analyze, board, bitstream, device, upload, "
            "download, play or stream; see haptogram --help");
    return action();
}

}  // namespace
}  // namespace haptogram::cli

int main(int argc, char** argv) {
    using haptogram::ErrorCode;
    // A closed pipe and a file that may not grow are errors to be told of, not silent deaths.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    const auto fail = [](const std::string& message, ErrorCode code) {
        haptogram::cli::complain(message);
        return haptogram::cli::exit_code(code);
    };
    try {
        const int code = haptogram::cli::run(argc, argv);
        std::cout.flush();
        if (!std::cout || std::fflush(stdout) != 0)
            return fail(fmt::format("standard output: {}; what was printed is incomplete",
                                    std::generic_category().message(errno)),
                        ErrorCode::bad_input);
        return code;
    } catch (const haptogram::Error& error) {
        // Libraries name a setting of theirs; here it is the option of the same name.
        const bool is_setting =
            error.code() == ErrorCode::bad_argument && (error.where() == "rate" || error.where() == "channels");
        return fail((is_setting ? "--" : "") + std::string(error.what()), error.code());
    } catch (const std::bad_alloc&) {
        return fail("out of memory; take fewer points or a coarser step", ErrorCode::failed);
    } catch (const std::system_error& error) {  // from {fmt}, when printing fails
        return fail(fmt::format("standard output: {}; what was printed is incomplete", error.what()),
                    ErrorCode::bad_input);
    } catch (const std::exception& error) {
        return fail(error.what(), ErrorCode::failed);
    }
}
