// SPDX-License-Identifier: Apache-2.0
#include "studio.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "browser_door.hpp"
#include "command.hpp"
#include "extras.hpp"
#include "interrupt.hpp"

namespace haptogram::cli {

void add_studio(CLI::App& app, Action& action);
namespace {

struct StudioOptions {
    studio::Options studio;
    bool no_browser = false, json = false;
};

int serve(const StudioOptions& options) {
    catch_interrupts();
    std::optional<studio::BrowserDoor> door;
    const auto listening = [&](const std::string& address, const std::string& missing) {
        if (!missing.empty()) complain(missing);
        if (options.json)
            fmt::print("{}\n", nlohmann::ordered_json{{"address", address}, {"page", missing.empty()}}.dump());
        else
            fmt::print("{}\n", address);
        std::fflush(stdout);
        if (!options.no_browser) door.emplace(address);
    };
    studio::run(options.studio, listening, interrupted);
    return 0;
}

}  // namespace

void add_studio(CLI::App& app, Action& action) {
    auto options = std::make_shared<StudioOptions>();
    CLI::App* sub = app.add_subcommand("studio",
                                       "Author a tactile object in the browser, see its field, play it on a board; "
                                       "prints the address, which only works on this machine. Ctrl-C ends it");
    sub->add_option("project", options->studio.project,
                    "Project, bundle or shape (PLY, OBJ, STL, OFF, PCD, 3MF, glTF, SVG, XYZ) that the page begins with "
                    "(default: an example)");
    sub->add_option("--port", options->studio.port,
                    fmt::format("Port of the page (default: {}, or one that is free)", studio::usual_port));
    sub->add_option("--page", options->studio.page, "Folder of the built page, for those who work on it");
    sub->add_option("--placed", options->studio.placed,
                    "Folder of what 'make bitstream' made, for bitstreams of the page")
        ->capture_default_str();
    sub->add_flag("--no-browser", options->no_browser, "Only print the address");
    sub->add_flag("--json", options->json, "Print the address as JSON");
    sub->callback([options, &action] { action = [options] { return serve(*options); }; });
}

void register_studio(Extras& extras) { extras.commands[Purpose::other].push_back(add_studio); }

}  // namespace haptogram::cli
