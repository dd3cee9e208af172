// SPDX-License-Identifier: Apache-2.0
#include "robot_place.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "frame_pins.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/robot/place.hpp"
#include "haptogram/verbs/compile.hpp"
#include "haptogram/verbs/level.hpp"
#include "played_frames.hpp"
#include "progress_line.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

using namespace fusion;
using nlohmann::ordered_json;

struct PlaceCommand {
    std::string mapping, robot = "cube-390", tables = "multimodal", array = "hoshi-18x18";
    std::optional<std::string> board;
    double target_mm = 250.0, start_mm = 300.0;
    PlaceOptions place;
    std::uint64_t frames = 5, seed = 1;
    std::string output;
    bool json = false;
};

void write_output(const std::string& path, const Placed& placed, const ordered_json& json) {
    if (!path.ends_with(".png")) {
        write_file(path, to_csv(placed));
        return;
    }
    Picture picture("shipped:tools/plot_placed.py");
    picture.add("rows.csv", to_csv(placed));
    picture.add("report.json", json.dump());
    picture.draw(path, ".csv and --json");
}

int place(PlaceCommand command) {
    PlaceOptions& options = command.place;
    options.mapping = mapping_of(command.mapping);
    options.target_m = command.target_mm * millimetre;
    options.start_m = command.start_mm * millimetre;
    options.robot_centre = {0.0, 0.0, options.target_m};
    options.geometry = robot::find_geometry(command.robot);
    options.plant.seed = command.seed;
    if (!command.output.empty() && command.output != "-" && !command.output.ends_with(".png") &&
        !command.output.ends_with(".csv"))
        throw bad_argument("output",
                           fmt::format("found \"{}\", expected a .csv table, a .png picture, or -", command.output));
    Project project;
    project.array = command.array;
    project.board = command.board;
    const ProjectInstrument instrument = instrument_of(project);
    const perception::Tables tables = perception::find_tables(command.tables);
    const SharedClock clock = shared_clock(options.controller.admittance.period_s,
                                           choose_timer(instrument.array, instrument.core).carrier_hz());
    const Placed placed = [&] {
        ProgressLine progress("place");
        return place_cube(options, instrument.array, tables, clock, progress.callback());
    }();
    std::vector<const Frame*> frames;
    for (const Frame& frame : placed.frames) frames.push_back(&frame);
    const std::vector<PlayedFrame> played = play_some(frames, command.frames, instrument, tables);
    const bool all_good = std::all_of(played.begin(), played.end(), [](const PlayedFrame& one) { return one.good; });

    Report report;
    report.add("mapping", command.mapping).add("target_mm", command.target_mm);
    report.add("array", instrument.array.name).add("robot", options.geometry.name);
    report.add("level", level_json(instrument.array.transducer), level_text(instrument.array.transducer));
    report.add("placed", placed.placed,
               placed.placed ? "" : "the cube was not placed: see the events, or take another start or range");
    report.add("time_s", placed.time_s);
    if (placed.placed) {
        report.add("error_mm", placed.error_m / millimetre,
                   fmt::format("{}: placed after {:.2f} s, {:+.2f} mm from {:g} mm", command.mapping, placed.time_s,
                               placed.error_m / millimetre, command.target_mm));
        report.add("weight_n", options.weight_n);
        report.add("weight_felt_n", placed.weight_n,
                   fmt::format("a weight of {:g} N was rendered; at rest the user held {:.3f} N, {:.3f} N by the "
                               "controller",
                               options.weight_n, placed.weight_n, placed.measured_n));
        report.add("weight_measured_n", placed.measured_n);
    }
    report.add("wrench", {0.0, 0.0, placed.rows.back().scene_n, 0.0, 0.0, 0.0});
    report.add("least_tension_n", placed.least_tension_n);
    report.add("period_s", clock.period_s(),
               fmt::format("one clock: {} carrier periods are one of the robot, {:.4g} Hz", clock.carrier_periods,
                           1.0 / clock.period_s()));
    report.add("frames", placed.frames.size()).add("points", placed.points);
    report.add("silent_points", placed.silent,
               placed.silent == 0 ? ""
                                  : fmt::format("{} of {} points stay silent; the first: {}", placed.silent,
                                                placed.points, placed.why));
    ordered_json events = ordered_json::array();
    for (const robot::Event& event : placed.events) {
        events.push_back({{"time_s", event.time_s}, {"kind", robot::name_of(event.kind)}, {"text", event.text}});
        report.tell(fmt::format("{:8.3f} s  {}: {}", event.time_s, robot::name_of(event.kind), event.text));
    }
    report.add("events", events);
    ordered_json pins = ordered_json::array();
    for (const PlayedFrame& one : played) {
        const Frame& frame = placed.frames[one.number];
        const PlaceRow& row = placed.rows[one.number];
        pins.push_back(to_json(one, frame, row.time_s));
        pins.back()["height_mm"] = row.height_m / millimetre;
        tell(report, one, frame, row.time_s);
    }
    report.add("pins", pins);
    if (!command.output.empty()) write_output(command.output, placed, report.json());
    if (command.output != "-") report.print(command.json);
    return placed.placed && all_good ? 0 : 1;
}

}  // namespace

void add_robot_place(CLI::App& robot, Action& action) {
    const auto command = std::make_shared<PlaceCommand>();
    PlaceOptions& place_options = command->place;
    CLI::App* sub = robot.add_subcommand(
        "place",
        "Cables and ultrasound together: a scripted user carries a cube to a height that only touch tells, and the "
        "simulated board plays it; exit code 1 when it was not placed, or the pins are not as asked");
    sub->add_option("--mapping", command->mapping,
                    "G1: a plane at the height is felt where it cuts the hand; G2: a focus on the palm rises in "
                    "frequency; G3: in perceived magnitude")
        ->required()
        ->check(CLI::IsMember({"G1", "G2", "G3"}));
    add_number(*sub, "--target", command->target_mm,
               "Height to find above the array, mm; the robot's frame is around it");
    add_number(*sub, "--start", command->start_mm, "Height at which the cube starts, mm");
    add_number(*sub, "--weight", place_options.weight_n, "Weight of the cube, by the cables, N");
    add_number(*sub, "--magnitude", place_options.magnitude, "Perceived magnitude of each focus, of G1 and G2");
    add_number(*sub, "--longest", place_options.longest_s, "The run ends after this, s");
    sub->add_option("--robot", command->robot, "Shipped robot, or a robot file (.toml)")->capture_default_str();
    sub->add_option("--array", command->array, "Shipped array, or an array file (.toml)")->capture_default_str();
    sub->add_option("--board", command->board, "Shipped board, board file, or configuration of the core");
    sub->add_option("--tables", command->tables, "Shipped perception file, or one of yours (.toml)")
        ->capture_default_str();
    sub->add_option("--frames", command->frames,
                    "Periods of the robot, evenly over the run, that the simulated board plays; 0: none")
        ->check(whole(0, 100000))
        ->capture_default_str();
    sub->add_option("--seed", command->seed, "Seed of the sensors' noise")->capture_default_str();
    sub->add_option("-o,--output", command->output, "The trace as .csv or .png; - is CSV on standard output");
    sub->add_flag("--json", command->json, "Print as JSON");
    sub->callback([command, &action] { action = [command] { return place(*command); }; });
}

}  // namespace haptogram::cli
