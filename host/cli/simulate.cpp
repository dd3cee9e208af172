// SPDX-License-Identifier: Apache-2.0
#include "simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/verbs/level.hpp"
#include "progress_line.hpp"
#include "reference_port.hpp"
#include "report.hpp"
#include "simulate_rig.hpp"
#include "simulation_report.hpp"
#include "source_options.hpp"

namespace haptogram::cli {

void add_board_run(CLI::App& app, Action& action);
void add_simulate(CLI::App& app, Action& action);
namespace {

struct SimulateOptions {
    Source source;
    std::uint32_t passes = 1;
    double duration_ms = 0.0;
    std::string load = "uart";
    std::string pulses;
    std::string trace;
    std::string report;
    SimulateRigOptions rig;
    bool json = false;
};

Report report_of(const Bundle& bundle, const sim::Simulation& s) {
    const Timer& t = bundle.manifest.timer;
    const sim::Playback& p = s.playback;
    const double clocks = static_cast<double>(p.clocks);
    const double playing = static_cast<double>(p.playing_clocks) / p.playing_seconds;
    nlohmann::ordered_json records = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < s.records.size(); ++i)
        records.push_back({{"index", bundle.manifest.index_of(i)},
                           {"cycles", s.records[i].cycles},
                           {"pressure_pa", s.records[i].check.pressure_pa},
                           {"pressure_kept", s.records[i].check.pressure_kept},
                           {"focus_error_mm", s.records[i].check.peak_offset_m / millimetre},
                           {"least_kept_allowed", s.records[i].limits.least_kept},
                           {"focus_error_allowed_mm", s.records[i].limits.most_offset_m / millimetre}});
    Report report;
    report.add("points", s.records.size(), fmt::format("points               {}", s.records.size()))
        .add("image_bytes", bundle.hex.size(), fmt::format("image size           {} bytes", bundle.hex.size()))
        .add("timer", {{"prescaler", t.prescaler}, {"cycle_ticks", t.cycle_ticks}, {"pulse_ticks", t.pulse_ticks}},
             fmt::format("timer                prescaler {}, cycle {} ticks, pulse {} ticks", t.prescaler,
                         t.cycle_ticks, t.pulse_ticks))
        .add("clocks", p.clocks,
             fmt::format("clocks simulated     {} ({:.1f} ms)", p.clocks, clocks / t.clock_hz * 1e3))
        .add("simulated_s", clocks / t.clock_hz)
        .add("mclk_per_s", clocks / p.seconds / 1e6,
             fmt::format("speed                {:.2f} Mclk/s, {:.2f} while playing ({:.3f} of real time)",
                         clocks / p.seconds / 1e6, playing / 1e6, playing / t.clock_hz))
        .add("playing_mclk_per_s", playing / 1e6)
        .add("playing_real_time_ratio", playing / t.clock_hz)
        .add("pulses", p.pulses.size(),
             fmt::format("pulses measured      {}, {} compared and equal to the image", p.pulses.size(),
                         p.pulse_report.checked))
        .add("pulses_equal_to_image", p.pulse_report.checked);
    add_checks(report, bundle.manifest, s);
    report.add("level", level_json(bundle.manifest.array.transducer));  // of pressure_pa
    return report
        .add("board", {{"underruns", p.status.underruns},
                       {"refused_records", p.status.refused_records},
                       {"frames_damaged", p.status.frames_damaged},
                       {"frames_repeated", p.status.frames_repeated},
                       {"watchdog_trips", p.status.watchdog_trips},
                       {"guard_trips", p.status.guard_trips}})
        .add("records", records);
}

const std::vector<OptionOf> options_of_one_or_rig = {{"--manifest", {"one board"}}, {"--array", {"one board"}},
                                                     {"--board", {"one board"}},    {"--duration", {"one board"}},
                                                     {"--load", {"one board"}},     {"--trace", {"one board"}},
                                                     {"--drift-ppm", {"a rig"}},    {"--seed", {"a rig"}}};

int simulate_board(const SimulateOptions& options) {
    std::vector<NamedPath> outputs;
    if (!options.pulses.empty()) outputs.push_back({"--pulses", options.pulses});
    if (!options.report.empty()) outputs.push_back({"--report", options.report});
    if (options.json) outputs.push_back({"--json", "-"});
    if (!options.trace.empty()) outputs.push_back({"--trace", options.trace});
    require_distinct(files_of(options.source), outputs);
    Source source = options.source;
    source.makers = path_makers();
    const Bundle bundle = open_bundle(source);

    sim::PlaybackOptions how;
    how.load_by_uart = options.load == "uart";
    how.passes = options.passes;
    if (options.duration_ms > 0.0) how.duration_s = options.duration_ms * 1e-3;
    std::optional<StagedFile> trace;
    if (!options.trace.empty()) {
        trace.emplace(options.trace);
        how.trace = trace->beside();
        if (how.trace.empty())
            throw Error(options.trace == "-" ? ErrorCode::bad_argument : ErrorCode::bad_input, options.trace,
                        "a trace needs a file of its own; name one that is no device or pipe");
    }
    sim::Simulation result;
    {
        ProgressLine progress("simulate");
        how.progress = progress.callback();
        result = sim::simulate(bundle, how);
    }
    if (trace) sim::require_whole_trace(trace->beside(), options.trace);
    const int code = finish(report_of(bundle, result), result, options.pulses, options.report, options.json);
    if (trace) trace->commit();
    return code;
}

int simulate(const SimulateOptions& options, const std::vector<std::string>& given) {
    const bool is_rig = is_rig_file(options.source.file);
    require_effect(given, options_of_one_or_rig, is_rig ? "a rig" : "one board", "what is simulated");
    if (!is_rig) return simulate_board(options);
    SimulateRigOptions rig = options.rig;
    rig.rig = options.source.file;
    rig.passes = options.passes;
    rig.pulses = options.pulses;
    rig.report = options.report;
    rig.json = options.json;
    return simulate_rig(rig);
}

}  // namespace

void add_simulate(CLI::App& app, Action& action) {
    auto options = std::make_shared<SimulateOptions>();
    CLI::App* sub = app.add_subcommand(
        "simulate",
        "Play an image on the Verilated FPGA, measure its pins, check contracts and foci; exit code 1 when one is off");
    auto* file =
        add_source_file(*sub, options->source, "Each tile of a rig is a Verilated board with a clock of its own. An ");
    sub->add_option("--rig", options->source.file, "The same as the file")->excludes(file)->group("");
    sub->add_option("--manifest", options->source.manifest, "Manifest (default: the image's name with .json)");
    add_array_and_board(*sub, options->source);
    auto* passes = sub->add_option("--passes", options->passes, "Passes over the sequence")
                       ->check(whole(1, 65535))
                       ->capture_default_str();
    sub->add_option("--duration", options->duration_ms, "Play for this many ms instead")
        ->check(positive())
        ->excludes(passes);
    sub->add_option("--load", options->load, "Through the simulated serial line, or straight into the memories")
        ->check(CLI::IsMember({"uart", "direct"}))
        ->capture_default_str();
    sub->add_option("--pulses", options->pulses, "Write the measured pulses (CSV)");
    sub->add_option("--trace", options->trace, "Write every signal (FST, for GTKWave)");
    sub->add_option("--drift-ppm", options->rig.drift_ppm,
                    "The crystals of a rig's boards are off by up to this much, to either side")
        ->check(CLI::Range(0.0, 50.0))
        ->capture_default_str();
    sub->add_option("--seed", options->rig.seed,
                    "Seed of a rig's drifts, start phases and what registers hold at power-up")
        ->check(whole(0, 4'294'967'295))
        ->capture_default_str();
    sub->add_option("--report", options->report, "Write the report (JSON)");
    sub->add_flag("--json", options->json, "Print the report as JSON");
    sub->callback(
        [options, sub, &action] { action = [options, given = given_to(*sub)] { return simulate(*options, given); }; });
}

void register_simulation(Extras& extras) {
    extras.commands[Purpose::measure].push_back(add_simulate);
    extras.below["board"].push_back(add_board_run);
    link::set_reference_boards(sim::reference_line);
}

}  // namespace haptogram::cli
