// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <csignal>
#include <exception>
#include <filesystem>

#include "base/error.hpp"
#include "command.hpp"
#include "image/manifest.hpp"

namespace haptogram::cli {

std::string manifest_path(const std::string& image) {
    std::filesystem::path path(image);
    return path.replace_extension(".json").string();
}

namespace {

int run(int argc, char** argv) {
    CLI::App app(
        "Mid-air tactile shapes by focused ultrasound: compile shapes to images, simulate the FPGA that plays them.",
        "haptogram");
    app.set_version_flag("--version", "haptogram " + version());
    app.require_subcommand(1);
    app.footer("Exit codes: 0 ok, 1 run failed, 2 usage, 3 bad input, 4 device or link.");
    Action action;
    add_compile(app, action);
    add_inspect(app, action);
    add_simulate(app, action);
    add_field(app, action);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : static_cast<int>(ErrorCode::usage);
    }
    return action();
}

}  // namespace
}  // namespace haptogram::cli

int main(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an error message, not a silent death
    try {
        return haptogram::cli::run(argc, argv);
    } catch (const haptogram::Error& error) {
        fmt::print(stderr, "haptogram: {}\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "haptogram: out of memory; take fewer points or a coarser step\n");
        return static_cast<int>(haptogram::ErrorCode::run_failed);
    } catch (const std::exception& error) {
        fmt::print(stderr, "haptogram: {}\n", error.what());
        return static_cast<int>(haptogram::ErrorCode::run_failed);
    }
}
