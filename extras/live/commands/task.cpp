// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <utility>

#include "command.hpp"
#include "haptogram/array/millimetres.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/live/scene_output.hpp"
#include "haptogram/live/tasks.hpp"
#include "haptogram/verbs/level.hpp"
#include "interrupt.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

using nlohmann::ordered_json;

/// What both tasks share.
struct TaskCommand {
    std::string rig = "cube-300", felt = "dynamic";
    std::size_t trials = 5, cameras = 4;
    std::uint64_t seed = 1;
    double distance_mm = 300.0;
    bool hidden = false, exact = false, json = false;
    std::optional<double> angle_deg, height_mm;           ///< of the surface, instead of drawn ones
    std::optional<double> edge_mm, x_mm, y_mm, turn_deg;  ///< of the cube, likewise
};

live::CameraOptions cameras_of(const TaskCommand& command, std::uint64_t trial) {
    live::CameraOptions cameras;
    cameras.count = command.cameras;
    cameras.distance_m = command.distance_mm * millimetre;
    if (command.exact) cameras.noise = no_depth_noise;
    cameras.noise.seed = command.seed * 1'000'003U + trial;
    return cameras;
}

void add_shared(CLI::App& sub, TaskCommand& command) {
    sub.add_option("--rig", command.rig, "Arrays that make the rings, a rig file or a shipped rig")
        ->capture_default_str();
    sub.add_option("--trials", command.trials, "How many")->check(whole(1, 10'000))->capture_default_str();
    sub.add_option("--seed", command.seed, "Seed of what is drawn and of the cameras' noise")
        ->check(whole(0, UINT64_MAX))
        ->capture_default_str();
    sub.add_option("--distance", command.distance_mm, "Distance of the cameras, mm")
        ->check(positive())
        ->capture_default_str();
    sub.add_flag("--exact", command.exact, "Cameras without noise");
    sub.add_flag("--json", command.json, "Print as JSON, each trial among it");
}

/// Calls one(array, trial, random) for each trial until all are done or the user interrupts, and reports what it
/// returned, and the level by which it was felt. @return the number of trials
template <class One>
std::size_t each_trial(const TaskCommand& command, Report& report, One one) {
    catch_interrupts();
    const Array array = joined(find_rig(command.rig));
    std::mt19937_64 random(command.seed);
    ordered_json trials = ordered_json::array();
    for (std::size_t trial = 1; trial <= command.trials && !interrupted(); ++trial)
        trials.push_back(one(array, trial, random));
    const std::size_t count = trials.size();
    report.add("trials", std::move(trials));
    if (command.felt != "none") report.add("level", level_json(array.transducer), level_text(array.transducer));
    return count;
}

/// Over the trials that succeeded.
struct Mean {
    std::size_t count = 0;
    double sum = 0.0;

    void add(double value) {
        ++count;
        sum += value;
    }
    double value() const { return sum / static_cast<double>(count); }
};

int lift_cubes(const TaskCommand& command) {
    Report report;
    Mean time_s, force_n;
    double made_j = 0.0;
    report.add("task", "lift").add("sight", command.hidden ? "hidden" : "seen").add("felt", command.felt);
    const std::size_t trials = each_trial(command, report, [&](const Array& array, std::size_t trial, auto& random) {
        live::LiftOptions options;
        options.cameras = cameras_of(command, trial);
        options.seen = !command.hidden;
        options.person_seed = command.seed * 1'000'003U + trial;
        options.felt = command.felt == "dynamic"  ? live::Felt::dynamic
                       : command.felt == "static" ? live::Felt::still
                                                  : live::Felt::nothing;
        live::draw_cube(options, random);
        if (command.edge_mm) options.edge_m = *command.edge_mm * millimetre;
        if (command.x_mm) options.x_m = *command.x_mm * millimetre;
        if (command.y_mm) options.y_m = *command.y_mm * millimetre;
        options.turn_deg = command.turn_deg.value_or(options.turn_deg);
        const live::LiftReport one = live::lift(array, options);
        report.tell(fmt::format(
            "trial {:<5} cube of {:.0f} mm at ({:.0f}, {:.0f}) mm, turned by {:.0f}°: {} after {:.2f} s, try {}; "
            "{:.1f} mm high, {:.2f} N holding, {:.2f} N at most",
            trial, 1e3 * options.edge_m, 1e3 * options.x_m, 1e3 * options.y_m, options.turn_deg,
            one.done ? "lifted" : "not lifted", one.time_s, one.tries, 1e3 * one.lifted_m, one.mean_force_n,
            one.most_force_n));
        made_j = std::max(made_j, one.energy_made_j);
        if (one.done) {
            time_s.add(one.time_s);
            force_n.add(one.mean_force_n);
        }
        return live::to_json(options, one);
    });
    report.add("lifted", time_s.count, fmt::format("lifted      {} of {}", time_s.count, trials));
    if (time_s.count > 0) {
        report.add("mean_time_s", time_s.value(),
                   fmt::format("mean time   {:.2f} s from the first touch", time_s.value()));
        report.add("mean_force_n", force_n.value(),
                   fmt::format("mean force  {:.2f} N of both fingers", force_n.value()));
    }
    report.add("energy_made_mj", 1e3 * made_j,
               fmt::format("energy      {:.3f} mJ at most came from nowhere", 1e3 * made_j));
    report.print(command.json);
    return 0;
}

int find_surfaces(const TaskCommand& command) {
    Report report;
    Mean angle_deg, height_mm, time_s;
    report.add("task", "surface").add("felt", command.felt);
    const std::size_t trials = each_trial(command, report, [&](const Array& array, std::size_t trial, auto& random) {
        live::SurfaceOptions options;
        options.cameras = cameras_of(command, trial);
        options.cameras.count = 1;
        options.middle = {0, 0, 0.15};
        options.nothing = command.felt == "none";
        options.sense.emplace();
        options.person_seed = command.seed * 1'000'003U + trial;
        options.fingers.ring.motion = command.felt == "static" ? FocusMotion::still : FocusMotion::revolving;
        live::draw_surface(options, random);
        if (command.angle_deg) options.angle_deg = *command.angle_deg;
        if (command.height_mm) options.height_m = *command.height_mm * millimetre;
        const live::SurfaceReport one = live::find_surface(array, options);
        report.tell(fmt::format("trial {:<5} {:.1f}° and {:.1f} mm: {} {:.1f}° and {:.1f} mm", trial, options.angle_deg,
                                1e3 * options.height_m, one.guessed ? "guessed" : "answer", one.angle_deg,
                                1e3 * one.height_m));
        angle_deg.add(std::abs(one.angle_error_deg));
        height_mm.add(1e3 * std::abs(one.height_error_m));
        if (one.done) time_s.add(one.time_s);
        return live::to_json(options, one);
    });
    report.add("answered", time_s.count, fmt::format("answered    {} of {}", time_s.count, trials));
    if (angle_deg.count > 0) {
        report.add("mean_angle_error_deg", angle_deg.value(),
                   fmt::format("angle       off by {:.2f}° on average", angle_deg.value()));
        report.add("mean_height_error_mm", height_mm.value(),
                   fmt::format("height      off by {:.2f} mm on average", height_mm.value()));
    }
    if (time_s.count > 0) {
        report.add("mean_time_s", time_s.value(),
                   fmt::format("mean time   {:.2f} s from the first touch", time_s.value()));
    }
    report.print(command.json);
    return 0;
}

}  // namespace

void add_task(CLI::App& app, Action& action) {
    CLI::App* task = app.add_subcommand(
        "task", "Two experiments of Matsubayashi et al. 2019, by scripted hands before simulated depth cameras");
    task->require_subcommand(1);
    auto options = std::make_shared<TaskCommand>();
    CLI::App* lift = task->add_subcommand("lift", "Two fingers lift a cube by 50 mm for 1.5 s");
    add_shared(*lift, *options);
    lift->add_flag("--hidden", options->hidden, "The hand does not see the cube");
    lift->add_option("--felt", options->felt, "What is played at the fingers, which feel it by their skin")
        ->check(CLI::IsMember({"dynamic", "static", "none"}))
        ->capture_default_str();
    lift->add_option("--cameras", options->cameras, "Around the room; 1: below it")
        ->check(whole(1, 8))
        ->capture_default_str();
    const CLI::Range beside(-60.0, 60.0);
    lift->add_option("--edge", options->edge_mm, "Edge of the cube, mm, in every trial (default: drawn)")
        ->check(CLI::Range(30.0, 50.0));
    lift->add_option("--x", options->x_mm, "X of its place on the floor, mm, likewise")->check(beside);
    lift->add_option("--y", options->y_mm, "The same along y")->check(beside);
    lift->add_option("--turn", options->turn_deg, "Turn of the cube on the floor, degrees, likewise")
        ->check(CLI::Range(0.0, 90.0));
    lift->callback([options, &action] { action = [options] { return lift_cubes(*options); }; });
    CLI::App* surface = task->add_subcommand("surface", "A finger finds the angle and the height of a surface");
    add_shared(*surface, *options);
    surface->add_option("--felt", options->felt, "What is played at the finger, which feels it by its skin")
        ->check(CLI::IsMember({"dynamic", "static", "none"}))
        ->capture_default_str();
    surface
        ->add_option("--angle", options->angle_deg,
                     "Angle of the surface, degrees about y, in every trial (default: drawn)")
        ->check(CLI::Range(-60.0, 60.0));
    surface->add_option("--height", options->height_mm, "Over the middle, mm, in every trial (default: drawn)")
        ->check(CLI::Range(-20.0, 20.0));
    surface->callback([options, &action] { action = [options] { return find_surfaces(*options); }; });
}

}  // namespace haptogram::cli
