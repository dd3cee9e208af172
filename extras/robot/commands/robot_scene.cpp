// SPDX-License-Identifier: Apache-2.0
#include "robot_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/render.hpp"
#include "haptogram/robot/scenes.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/level.hpp"
#include "haptogram/verbs/source.hpp"
#include "played_frames.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {
namespace {

using namespace fusion;
using nlohmann::ordered_json;

/// What both modes have in common.
struct SceneCommand {
    std::string robot = "cube-390", tables = "multimodal", array = "hoshi-18x18";
    std::optional<std::string> board;
    std::string centre = "0,0,250";
    std::vector<std::string> way;
    double speed_mm_s = 50.0, wait_s = 1.0;
    robot::Impedance hand;
    std::uint64_t frames = 5, seed = 1;
    std::vector<std::string> outputs;
    bool json = false;
};

struct ExploreCommand : SceneCommand {
    ObjectSource object;
    std::string object_centre = "0,0,250", object_angles = "0,0,0";
    std::optional<double> size_mm, height_mm;
    double surface_mm = 240.0, cell_mm = 10.0;
    ExploreScene scene;
};

struct TellCommand : SceneCommand {
    std::string value = "distance", sign = "frequency", shape = "focus";
    std::optional<double> low, high;
    double height_mm = 250.0, range_mm = 100.0, cell_mm = 20.0, size_mm = 20.0;
    TellScene scene;
};

void write_outputs(const SceneCommand& command, const std::string& title, const SceneRun& run, double carrier_hz,
                   const ordered_json& report) {
    for (const std::string& output : command.outputs) {
        if (output.ends_with(".json")) {
            write_file(output, to_json_text(run.path(), carrier_hz));
        } else if (output.ends_with(".png")) {
            Picture picture("shipped:tools/plot_scene.py");
            picture.add("rows.csv", to_csv(run));
            picture.add("report.json", report.dump());
            picture.add("title.txt", title);
            picture.draw(output, ".csv and .json");
        } else {
            write_file(output, to_csv(run));
        }
    }
}

void check_outputs(const SceneCommand& command) {
    std::vector<NamedPath> outputs;
    for (const std::string& output : command.outputs) {
        if (!output.ends_with(".json") && !output.ends_with(".csv") && !output.ends_with(".png"))
            throw bad_argument("output", fmt::format("found \"{}\", expected a .json path, a .csv table or a .png "
                                                     "picture",
                                                     output));
        outputs.push_back({"--output", output});
    }
    require_distinct({}, outputs);
}

/// @param scene_of  makes the scene for a clock
template <class MakeScene>
int play(const SceneCommand& command, const std::string& title, MakeScene make_scene, double weight_n) {
    check_outputs(command);
    Project project;
    project.array = command.array;
    project.board = command.board;
    const ProjectInstrument instrument = instrument_of(project);
    const perception::Tables tables = perception::find_tables(command.tables);
    TogetherOptions options;
    options.robot_centre = parse_point_mm("robot_center", command.centre);
    options.geometry = robot::find_geometry(command.robot);
    options.plant.seed = command.seed;
    const double carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    const SharedClock clock = shared_clock(options.controller.admittance.period_s, carrier_hz);
    HandWay way{{}, command.speed_mm_s * millimetre, command.wait_s, command.hand, weight_n};
    for (const std::string& place : command.way) way.places.push_back(parse_point_mm("way", place));
    const SceneRun run = [&] {
        ProgressLine progress("play");
        return play_scene(make_scene(clock), way, options, instrument.array, tables, clock, progress.callback());
    }();
    std::vector<const Frame*> frames;
    for (const Period& period : run.periods) frames.push_back(&period.frame);
    const std::vector<PlayedFrame> played = play_some(frames, command.frames, instrument, tables);

    Report report;
    report.add("scene", title, title);
    report.add("array", instrument.array.name).add("robot", options.geometry.name);
    report.add("level", level_json(instrument.array.transducer), level_text(instrument.array.transducer));
    report.add("seconds", run.periods.back().time_s);
    report.add("period_s", clock.period_s(),
               fmt::format("one clock: {} carrier periods are one of the robot, {:.4g} Hz", clock.carrier_periods,
                           1.0 / clock.period_s()));
    const auto felt = static_cast<std::size_t>(
        std::count_if(frames.begin(), frames.end(), [](const Frame* frame) { return !frame->points.empty(); }));
    report.add("frames", frames.size()).add("frames_felt", felt);
    report.add("points", run.points,
               fmt::format("in {} of {} periods something is felt by ultrasound; {} points in all", felt, frames.size(),
                           run.points));
    report.add("silent_points", run.silent,
               run.silent == 0
                   ? ""
                   : fmt::format("{} of {} points stay silent; the first: {}", run.silent, run.points, run.why));
    const SceneForces forces = forces_of(run);
    report.add("most_force_n", forces.most_n,
               fmt::format("the scene asked for up to {:.3f} N, and the cables rendered up to {:.3f} N; what the "
                           "controller took for the user's force was {:.3f} N off at most",
                           forces.most_n, forces.rendered_n, forces.most_off_n));
    report.add("rendered_n", forces.rendered_n);
    report.add("missing_n", forces.missing_n,
               forces.missing_n == 0.0
                   ? ""
                   : fmt::format("up to {:.3f} N could not be rendered; see haptogram robot tension --largest",
                                 forces.missing_n));
    report.add("most_force_off_n", forces.most_off_n);
    report.add("least_tension_n", run.least_tension_n);
    ordered_json events = ordered_json::array(), pins = ordered_json::array();
    for (const robot::Event& event : run.events) {
        events.push_back({{"time_s", event.time_s}, {"kind", robot::name_of(event.kind)}, {"text", event.text}});
        report.tell(fmt::format("{:8.3f} s  {}: {}", event.time_s, robot::name_of(event.kind), event.text));
    }
    report.add("events", events);
    for (const PlayedFrame& one : played) {
        const double time = run.periods[one.number].time_s;
        pins.push_back(to_json(one, *frames[one.number], time));
        tell(report, one, *frames[one.number], time);
    }
    report.add("pins", pins);
    write_outputs(command, title, run, carrier_hz, report.json());
    report.print(command.json);
    const bool good = std::all_of(played.begin(), played.end(), [](const PlayedFrame& one) { return one.good; });
    return good && run.events.empty() ? 0 : 1;
}

int explore(ExploreCommand command) {
    command.object.centre = parse_point_mm("center", command.object_centre);
    command.object.angles_deg = parse_three("rotate", command.object_angles, "degrees");
    if (command.size_mm) command.object.size_m = *command.size_mm * millimetre;
    if (command.height_mm) command.object.height_m = *command.height_mm * millimetre;
    command.object.readers = path_makers().readers;
    command.scene.object = open_object(command.object);
    command.scene.surface.height_m = command.surface_mm * millimetre;
    command.scene.surface.cell_m = command.cell_mm * millimetre;
    const std::string title = fmt::format("mode W1: {} by ultrasound; {:g} N and a surface at {:g} mm by cables",
                                          command.scene.object.name, command.scene.weight_n, command.surface_mm);
    return play(
        command, title, [&](const SharedClock& clock) { return scene_of(command.scene, clock); },
        command.scene.weight_n);
}

int tell_value(TellCommand command) {
    PalmPattern& pattern = command.scene.pattern;
    pattern.sign = palm_sign(command.sign);
    pattern.shape = palm_shape(command.shape);
    pattern.size_m = command.size_mm * millimetre;
    const SignRange usual = usual_range(pattern.sign);
    const double unit = pattern.sign == PalmSign::translation ? millimetre : 1.0;
    pattern.low = command.low ? *command.low * unit : usual.low;
    pattern.high = command.high ? *command.high * unit : usual.high;
    command.scene.value = palm_value(command.value);
    command.scene.height_m = command.height_mm * millimetre;
    command.scene.range_m = command.range_mm * millimetre;
    command.scene.cell_m = command.cell_mm * millimetre;
    const std::string title = fmt::format("mode W2: {} by the {} of a {} on the palm; {:g} N by cables", command.value,
                                          command.sign, command.shape, command.scene.weight_n);
    return play(
        command, title, [&](const SharedClock&) { return scene_of(command.scene); }, command.scene.weight_n);
}

void add_common(CLI::App& sub, SceneCommand& command) {
    sub.add_option("--way", command.way,
                   "x,y,z, mm above the array: places of the palm, one after the other, straight from each to the next")
        ->capture_default_str();
    add_number(sub, "--speed", command.speed_mm_s, "On that way, mm/s");
    sub.add_option("--wait", command.wait_s, "Wait at its end, s")->check(not_negative())->capture_default_str();
    add_number(sub, "--hand-stiffness", command.hand.stiffness_n_m, "Stiffness of the hand about its way, N/m");
    sub.add_option("--robot", command.robot, "Shipped robot, or a robot file (.toml)")->capture_default_str();
    sub.add_option("--robot-center", command.centre, "x,y,z, mm: of the robot's frame above the array")
        ->capture_default_str();
    sub.add_option("--array", command.array, "Shipped array, or an array file (.toml)")->capture_default_str();
    sub.add_option("--board", command.board, "Shipped board, board file, or configuration of the core");
    sub.add_option("--tables", command.tables, "Shipped perception file, or one of yours (.toml)")
        ->capture_default_str();
    sub.add_option("--frames", command.frames,
                   "Periods of the robot, evenly over the run, that the simulated board plays; 0: none")
        ->check(whole(0, 100000))
        ->capture_default_str();
    sub.add_option("--seed", command.seed, "Seed of the sensors' noise")->capture_default_str();
    sub.add_flag("--json", command.json, "Print as JSON");
    sub.add_option("-o,--output", command.outputs,
                   "The ultrasound's path as .json for compile, the trace as .csv, or a .png picture; may be repeated");
}

}  // namespace

void add_robot_explore(CLI::App& robot, Action& action) {
    const auto command = std::make_shared<ExploreCommand>();
    command->way = {"-45,0,250", "45,0,250", "45,0,236", "-45,0,236"};
    CLI::App* sub = robot.add_subcommand(
        "explore",
        "Cables and ultrasound together: ultrasound shows where an object's edges and corners meet the hand; "
        "the cables give weight, and a surface with friction and texture; exit code 1 when the robot noticed a fault, "
        "or the pins of the simulated board are not as asked");
    ExploreScene& scene = command->scene;
    command->object.name = "cube";
    sub->add_option("object", command->object.name,
                    fmt::format("{}, or a mesh file (PLY, OBJ, STL, OFF, 3MF, glTF) of a closed surface",
                                fmt::join(object_kinds(), ", ")))
        ->capture_default_str();
    sub->add_option("--size", command->size_mm,
                    "Edge or diameter of the object, largest extent of a mesh, mm (default: 100, a mesh as it is)")
        ->check(positive());
    sub->add_option("--height", command->height_mm, "Height of a cone, pyramid or cylinder, mm (default: the size)")
        ->check(positive());
    sub->add_option("--center", command->object_centre, "Center of the object: x,y,z mm")->capture_default_str();
    sub->add_option("--rotate", command->object_angles, "Turns of the object: degrees about x, then y, then z")
        ->capture_default_str();
    sub->add_option("--unit", command->object.unit, "Unit of a mesh file's coordinates")
        ->check(CLI::IsMember({"mm", "cm", "m", "inch"}))
        ->capture_default_str();
    add_number(*sub, "--magnitude", scene.magnitude, "Perceived magnitude of each focus");
    add_number(*sub, "--frequency", scene.frequency_hz, "Frequency of the square wave that modulates them, Hz");
    sub->add_option("--tilt", scene.tilt_deg, "Tilt of the hand, fingers down, degrees")->capture_default_str();
    sub->add_option("--weight", scene.weight_n, "Weight in the hand, N")->check(not_negative())->capture_default_str();
    add_number(*sub, "--surface", command->surface_mm, "Height of the surface above the array, mm");
    add_number(*sub, "--stiffness", scene.surface.stiffness_n_m, "Stiffness of the surface, N/m");
    sub->add_option("--friction", scene.surface.friction, "Tangential over normal force, while it slides")
        ->check(not_negative())
        ->capture_default_str();
    sub->add_option("--texture", scene.surface.texture, "Largest tangential over normal force of a cell")
        ->check(not_negative())
        ->capture_default_str();
    add_number(*sub, "--cell", command->cell_mm, "Edge of a cell of the texture, mm");
    add_common(*sub, *command);
    sub->callback([command, &action] { action = [command] { return explore(*command); }; });
}

void add_robot_tell(CLI::App& robot, Action& action) {
    const auto command = std::make_shared<TellCommand>();
    command->way = {"-30,0,290", "-30,0,245", "30,0,245"};
    CLI::App* sub = robot.add_subcommand(
        "tell",
        "Cables and ultrasound together: the cables give weight; a pattern on the palm tells a distance, a "
        "texture or a hardness; exit code 1 when the robot noticed a fault, or the pins of the simulated board are not "
        "as asked");
    TellScene& scene = command->scene;
    sub->add_option("--value", command->value,
                    "distance: how near the palm is to the height; texture: of a cloth, and hardness: of a spring, "
                    "which are told below the height")
        ->check(CLI::IsMember({"distance", "texture", "hardness"}))
        ->capture_default_str();
    sub->add_option("--sign", command->sign, "Property of the pattern that tells the value")
        ->check(CLI::IsMember({"intensity", "frequency", "translation", "rotation", "scaling"}))
        ->capture_default_str();
    sub->add_option("--pattern", command->shape, "On the palm")
        ->check(CLI::IsMember({"focus", "line", "ring"}))
        ->capture_default_str();
    sub->add_option("--points", scene.points, "Points of a line or a ring")
        ->check(whole(2, 1000))
        ->capture_default_str();
    add_number(*sub, "--size", command->size_mm, "Length of the line, diameter of the ring, mm");
    sub->add_option("--low", command->low,
                    "The sign at the value 0: a magnitude (default 1), Hz (80), mm along the hand (-30), degrees (0) "
                    "or a factor (0.5)");
    sub->add_option("--high", command->high, "The same at the value 1 (defaults: 4, 300, 30, 90, 2)");
    add_number(*sub, "--magnitude", scene.pattern.magnitude, "Perceived magnitude, unless it is the sign");
    add_number(*sub, "--frequency", scene.pattern.frequency_hz,
               "Frequency of the modulation, Hz, unless it is the sign");
    sub->add_option("--weight", scene.weight_n, "Weight in the hand, N")->check(not_negative())->capture_default_str();
    add_number(*sub, "--height", command->height_mm, "Above the array, mm: what is near, or the surface");
    add_number(*sub, "--range", command->range_mm,
               "Range of the distance, mm: farther away the pattern does not change");
    add_number(*sub, "--cell", command->cell_mm, "Mesh of the cloth: from thread to thread, mm");
    add_number(*sub, "--stiffness", scene.stiffness_n_m, "Stiffness that is told as hardness, N/m");
    add_number(*sub, "--softest", scene.softest_n_m, "Stiffness told as the value 0, N/m");
    add_number(*sub, "--hardest", scene.hardest_n_m, "Stiffness told as the value 1, N/m");
    add_common(*sub, *command);
    sub->callback([command, &action] { action = [command] { return tell_value(*command); }; });
}

}  // namespace haptogram::cli
