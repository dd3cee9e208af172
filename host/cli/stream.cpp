// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/stream.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/instrument/compile.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct StreamOptions {
    std::string file = "-";
    std::string path;
    std::optional<std::string> array, board;
    std::size_t points = Project{}.points;
    std::uint64_t loops = 1;
    link::PortSettings port;
    link::StreamSettings stream{.warn = complain};
    std::uint16_t dwell = 1;
    double rate = 0.0;
    bool foci = false;
    std::optional<std::string> am, am_law;
    bool json = false;
};

Compiled compiled_path(const StreamOptions& options) {
    Project project;
    project.path = options.path;
    project.array = options.array;
    project.board = options.board;
    project.points = options.points;
    project.am = options.am.value_or("");
    project.am_law = law_of(options.am_law.value_or("pressure"));
    return compile_for_stream(project, options.path);
}

int stream(const StreamOptions& options) {
    catch_interrupts();
    std::optional<Compiled> compiled;
    if (!options.path.empty()) compiled = compiled_path(options);
    link::Device device(options.port);
    const std::string what = options.foci ? "foci" : "indices";
    ProgressLine progress("stream");
    const link::Watch watch = [&](const link::Playing& now) {
        progress.note(fmt::format("{} {}", now.sent, what));
        return !interrupted();
    };
    link::Played played;
    if (compiled) {
        played = link::stream(device, options.stream, compiled->bundle.image, options.loops, options.path,
                              progress.callback(), watch);
    } else {
        const double rate = options.rate;
        const std::uint16_t dwell = rate > 0.0 ? link::dwell_of(rate, link::device_carrier_hz(device)) : options.dwell;
        link::StreamSettings settings = options.stream;
        settings.am = {options.am.value_or(""), law_of(options.am_law.value_or("pressure"))};
        if (options.foci) {
            link::FocusLines source(options.file, dwell);
            played = link::stream(device, settings, source, watch);
        } else {
            link::StreamLines source(options.file, dwell, link::highest_index(device));
            played = link::stream(device, settings, source, watch);
        }
    }
    tell(streamed_to_json(played), options.json,
         fmt::format("{} {}, {} underruns", played.sent, what, played.underruns));
    if (compiled && played.underruns > 0)
        complain(
            "warning: the board had to wait for indices, and held a focus meanwhile; entries of different dwells are a "
            "frame each on the line, so take longer dwells, fewer points or a lower speed");
    if (compiled)
        for (const std::string& warning : compiled->warnings) complain("warning: " + warning);
    return 0;
}

}  // namespace

void add_stream(CLI::App& app, Action& action) {
    auto options = std::make_shared<StreamOptions>();
    CLI::App* sub =
        app.add_subcommand("stream",
                           "Turn the outputs on and play indices or foci as they come, or a path, no faster than "
                           "the board takes them; then off again");
    auto* file =
        sub->add_option("file", options->file,
                        "Lines 'index' or 'index dwell', of records or of the board's foci; - is standard input")
            ->capture_default_str();
    auto* path = sub->add_option("--path", options->path,
                                 "A path file as compile takes it, instead of indices: its records are written into "
                                 "the board, in place of what is there, and its sequence is streamed, however long")
                     ->excludes(file);
    sub->add_option("--array", options->array, "Of --path, as for compile")->needs(path);
    sub->add_option("--board", options->board, "Of --path, as for compile")->needs(path);
    sub->add_option("--points", options->points,
                    "Of --path, as for compile: how often an .adaptics pattern is looked at")
        ->needs(path)
        ->check(whole(1, 65535))
        ->capture_default_str();
    sub->add_option("--loops", options->loops, "Passes over the path; 0: until Ctrl-C")
        ->needs(path)
        ->check(whole(0, 65535))
        ->capture_default_str();
    sub->add_flag(
        "--foci", options->foci,
        "Lines 'x y z', 'x y z amplitude' or 'x y z amplitude dwell' instead, in mm in the array's frame; the "
        "board computes the rest, for the array of the image of foci in it");
    add_port_options(*sub, options->port);
    auto* dwell = sub->add_option("--dwell", options->dwell,
                                  "Cycles that an index or a focus lasts if its line does not say; 0: until the next")
                      ->excludes(path)
                      ->check(whole(0, 65535))
                      ->capture_default_str();
    sub->add_option("--rate", options->rate,
                    "Indices or foci a second instead: the whole number of cycles that is nearest")
        ->check(positive())
        ->excludes(dwell)
        ->excludes(path);
    add_am(*sub, options->am, options->am_law);
    add_watchdog_option(*sub, options->stream.watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return stream(*options); }; });
}

}  // namespace haptogram::cli
