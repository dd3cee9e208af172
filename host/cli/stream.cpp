// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/stream.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/focus_ring.hpp"
#include "haptogram/link/modulate.hpp"
#include "haptogram/link/pattern_stream.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "haptogram/link/rig_stream.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/rig.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "rig_ports.hpp"
#include "setting_options.hpp"

namespace haptogram::cli {
namespace {

struct StreamOptions {
    std::string file = "-";
    std::string path;
    std::optional<std::string> array, board;
    std::optional<SettingValue> points;
    std::uint64_t loops = 1;
    RigPorts ports;
    std::string on_loss = "off";
    link::StreamSettings stream{.warn = complain};
    std::uint16_t dwell = 1;
    double rate = 0.0;
    bool foci = false, live = false, dwell_given = false;
    std::optional<std::string> am, am_law;
    bool json = false;
};

Project project_of(const StreamOptions& options) {
    Project project;
    project.makers = path_makers();
    project.path = options.path;
    project.array = options.array;
    project.board = options.board;
    if (options.points) {
        const auto& points = setting_called("--points");
        points.put(project, points, *options.points);
        require_effect(std::vector<std::string>{"--points"}, project);
    }
    project.am = options.am.value_or("");
    project.am_law = law_of(options.am_law.value_or("pressure"));
    return project;
}

/// What a board or a rig is told of a path that was streamed.
void warn_of(const Compiled& compiled, std::uint64_t underruns) {
    if (underruns > 0)
        complain(
            "warning: the board had to wait for indices, and held a focus meanwhile; entries of different dwells are a "
            "frame each on the line, so take longer dwells, fewer points or a lower speed");
    for (const std::string& warning : compiled.warnings) complain("warning: " + warning);
}

int stream_rig(const StreamOptions& options) {
    if (options.foci)
        throw bad_argument("foci",
                           "a rig's tiles share no frame in which a line could name a focus; stream indices, or "
                           "a path with --path");
    if (options.am && options.path.empty())
        throw bad_argument("am", "a rig plays as it was compiled; compile it with that setting");
    std::optional<CompiledRig> compiled;
    if (!options.path.empty()) compiled = compile_rig_for_stream(project_of(options), options.ports.rig, options.path);
    const RigBundle bundle = compiled ? compiled->bundle : load_rig_bundle(options.ports.rig);
    catch_interrupts();  // before this nothing is on, and compiling a path may take long
    const link::RigDevices devices(bundle, options.ports.of(bundle));
    for (const link::PortSettings& port : options.ports.of(bundle)) warn_of_latency(port.port);
    const link::RigSettings settings{
        .watchdog_ms = options.stream.watchdog_ms, .on_loss = on_loss_of(options.on_loss), .warn = complain};
    ProgressLine progress("stream");
    const link::RigWatch watch = [&](const link::RigPlaying& now) {
        progress.note(fmt::format("{} indices, {}", now.sent, words_of(now)));
        return !interrupted();
    };
    link::RigPlayed played;
    if (compiled) {
        played = link::stream(devices.tiles(), settings, options.loops, progress.callback(), watch);
    } else {
        const double carrier_hz = bundle.whole.manifest.timer.carrier_hz();
        const std::uint16_t dwell = options.rate > 0.0 ? link::dwell_of(options.rate, carrier_hz) : options.dwell;
        link::StreamLines source(options.file, dwell, link::highest_index(bundle.tiles.front().image));
        played = link::stream(devices.tiles(), settings, source, watch);
    }
    tell_rig(played, link::streamed_to_json(played), options.json,
             fmt::format("{} indices, {} underruns, {} refused records", played.sent, played.underruns,
                         played.refused_records));
    if (compiled) warn_of(compiled->whole, played.underruns);
    return 0;
}

/// A pattern, or a record of foci, for each carrier period.
int stream_patterns(const StreamOptions& options) {
    if (options.dwell_given && !options.foci)
        throw bad_argument("dwell", "a pattern lasts for one carrier period; with --foci a line's dwell counts");
    const link::PortSettings port = options.ports.one();
    catch_interrupts();
    link::Device device(port);
    warn_of_latency(port.port);
    std::optional<link::ModulationOn> modulated;
    if (options.am) {
        const link::Am am{*options.am, law_of(options.am_law.value_or("pressure")), 1.0 / link::pattern_period_s};
        modulated.emplace(device, modulation_of(am, device), options.stream.warn);
    }
    ProgressLine progress("stream");
    const auto watch = [&](const link::PatternsPlaying& now) {
        progress.note(fmt::format("{} patterns", now.played.sent));
        return !interrupted();
    };
    const auto play = [&](auto& patterns, std::size_t words) {
        const link::PatternSource source = [&](std::uint64_t, std::span<std::uint16_t> room) {
            return patterns.take(room, words);
        };
        return play_patterns(device, {.foci = options.foci, .watchdog_ms = options.stream.watchdog_ms}, source, watch);
    };
    link::PlayedPatterns played;
    if (options.foci) {
        link::FocusLines lines(options.file, options.dwell);
        link::FocusPatterns patterns(lines);
        played = play(patterns, 4 * link::make_ring(device).each);
    } else {
        link::PatternBytes patterns(options.file);
        played = play(patterns, device.identity().channels);
    }
    tell(to_json(played), options.json,
         fmt::format("{} patterns, {} too late, {} periods without one", played.sent, played.late, played.lost));
    if (played.late > 0)
        complain(
            "warning: some patterns came too late for their carrier period; a computer with less to do, a real-time "
            "class, or a board with more slots helps");
    return 0;
}

int stream(const StreamOptions& options) {
    if (options.ports.is_rig() && options.live)
        throw bad_argument("live", "a stream of patterns goes to one board; give its --port");
    if (options.ports.is_rig() && options.foci)
        throw bad_argument("foci", "a stream of foci goes to one board; give its --port, or indices to the rig");
    if (options.ports.is_rig()) return stream_rig(options);
    if (options.live) return stream_patterns(options);
    const link::PortSettings port = options.ports.one();
    std::optional<Compiled> compiled;
    if (!options.path.empty()) compiled = compile_for_stream(project_of(options), options.path);
    catch_interrupts();  // before this nothing is on, and compiling a path may take long
    link::Device device(port);
    warn_of_latency(port.port);
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
         fmt::format("{} {}, {} underruns, {} refused records", played.sent, what, played.underruns,
                     played.refused_records));
    if (compiled) warn_of(*compiled, played.underruns);
    return 0;
}

}  // namespace

void add_stream(CLI::App& app, Action& action) {
    auto options = std::make_shared<StreamOptions>();
    CLI::App* sub = app.add_subcommand("stream",
                                       "Play indices or foci as they come, or a path, on a board or a rig's boards: "
                                       "outputs go on, and off at the end");
    auto* file =
        sub->add_option("file", options->file,
                        "Lines 'index' or 'index dwell', of records or of the board's foci; - is standard input")
            ->capture_default_str();
    auto* path = sub->add_option("--path", options->path,
                                 "A path file as compile takes it, instead of indices: its records are written into "
                                 "the board, in place of what is there, and its sequence is streamed, however long")
                     ->excludes(file);
    sub->add_option("--array", options->array, "Array of --path, as for compile")->needs(path);
    sub->add_option("--board", options->board, "Board of --path, as for compile")->needs(path);
    const auto& points = setting_called("--points");
    add_setting(*sub, points, default_of(points), [options](const SettingValue& value) { options->points = value; })
        ->needs(path)
        ->description("Samples of an .adaptics pattern of --path");
    sub->add_option("--loops", options->loops, "Passes over the path; 0: until Ctrl-C")
        ->needs(path)
        ->check(whole(0, 65535))
        ->capture_default_str();
    sub->add_flag(
           "--foci", options->foci,
           "Lines 'x y z', 'x y z amplitude' or 'x y z amplitude dwell' instead, in mm in the array's frame; the "
           "board computes the rest, for the array of the image of foci in it, which this program does not know: "
           "whether a place is in reach is not checked")
        ->excludes(path);
    auto* live = sub->add_flag(
        "--live", options->live,
        "A new pattern in each carrier period, on boards that take streams of them: the line 'patterns CHANNELS', then "
        "two bytes for each channel, its phase in 1/256 of the period and its amplitude in 1/255; with --foci lines as "
        "above, for as many periods as their dwell says. What comes too late for its period is counted and not played");
    live->excludes(path);
    auto* rig = add_rig_port_options(*sub, options->ports);
    rig->description(
        "Boards that play as one: the rig manifest (.json) from compile --rig, whose images upload has written; an "
        "index is the same record on all, each from its own image. With --path: a rig as compile takes it, whose "
        "boards get their images now");
    add_on_loss_option(*sub, rig, options->on_loss);
    auto* dwell =
        sub->add_option("--dwell", options->dwell,
                        "Cycles that an index or a focus lasts if its line does not say; 0: until the next, which "
                        "the tiles of a rig begin some 5 ms after it came, or later")
            ->excludes(path)
            ->check(whole(0, 65535))
            ->capture_default_str();
    sub->add_option("--rate", options->rate,
                    "Indices or foci a second instead: the whole number of cycles that is nearest")
        ->check(positive())
        ->excludes(dwell)
        ->excludes(path)
        ->excludes(live);
    add_am(*sub, options->am, options->am_law);
    add_watchdog_option(*sub, options->stream.watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, dwell, &action] {
        options->dwell_given = dwell->count() > 0;
        action = [options] { return stream(*options); };
    });
}

}  // namespace haptogram::cli
