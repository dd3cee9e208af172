// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "command.hpp"
#include "extras.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/robot_file.hpp"
#include "haptogram/robot/simulate.hpp"
#include "haptogram/robot/tension.hpp"
#include "haptogram/robot/workspace.hpp"
#include "haptogram/verbs/source.hpp"
#include "progress_line.hpp"
#include "report.hpp"
#include "robot_place.hpp"
#include "robot_scene.hpp"

namespace haptogram::cli {

void add_robot(CLI::App& app, Action& action);
namespace {

using namespace robot;
using nlohmann::ordered_json;

constexpr double degree = std::numbers::pi / 180.0;

struct RobotOptions {
    std::string robot = "cube-390";
    double edge_mm = 0.0;  // 0: the robot's own frame
    std::string position = "0,0,0", angles = "0,0,0";
    std::vector<double> lengths_mm;
    std::string force = "0,0,0", torque = "0,0,0", choice = "norm";
    bool largest = false;
    double step_mm = 30.0, angle_deg = 15.0;
    std::string turns = "all";
    double duration_s = 10.0;
    std::vector<std::string> pushes, faults;
    double wander_mm = 0.0;
    std::uint64_t seed = 1;
    std::string output;
    bool json = false;
};

Geometry geometry_of(const RobotOptions& options) {
    const Geometry geometry = find_geometry(options.robot);
    return options.edge_mm > 0.0 ? with_edge(geometry, options.edge_mm * 1e-3) : geometry;
}

Vector3 three(const std::string& setting, const std::string& text, std::string_view unit) {
    const Vec3 found = parse_three(setting, text, unit);
    return {found.x, found.y, found.z};
}

/// What is to happen after the end never happens.
void require_within(const char* setting, const std::string& text, double time_s, double duration_s) {
    if (time_s >= duration_s)
        throw bad_argument(
            setting,
            fmt::format("'{}' begins at {:g} s, and the simulation ends at {:g} s; give --duration a longer time", text,
                        time_s, duration_s),
            {"duration"});
}

robot::Pose pose_from(const RobotOptions& options) {
    return {three("position", options.position, "mm") * 1e-3,
            rotation_xyz(three("angles", options.angles, "degrees") * degree)};
}

double rounded(double value, double digits = 1e6) { return std::round(value * digits) / digits + 0.0; }

template <class Vector>
ordered_json list(const Vector& values, double factor = 1.0) {
    ordered_json json = ordered_json::array();
    for (int i = 0; i < values.size(); ++i) json.push_back(rounded(values[i] * factor));
    return json;
}

template <class Vector>
std::string words(const Vector& values, double factor, int decimals) {
    std::string text;
    for (int i = 0; i < values.size(); ++i)
        text += fmt::format("{}{:.{}f}", i == 0 ? "" : " ", values[i] * factor + 0.0, decimals);
    return text;
}

ordered_json json_of(const Nearness& near) {
    ordered_json json = {{"cable", near.first + 1}};
    if (near.second >= 0) json["other_cable"] = near.second + 1;
    json["distance_mm"] = rounded(near.distance_m * 1e3);
    json["room_mm"] = rounded(near.room_m * 1e3);
    return json;
}

int inverse(const RobotOptions& options) {
    const Geometry geometry = geometry_of(options);
    const robot::Pose pose = pose_from(options);
    const PerCable lengths = cable_lengths(geometry, pose);
    const std::string why = out_of_length(geometry, lengths), touching = interference(geometry, pose);
    const Clearance room = clearance(geometry, pose);
    Report report;
    report.add("lengths_mm", list(lengths, 1e3), "lengths / mm: " + words(lengths, 1e3, 4));
    report.add("within_limits", why.empty(), why);
    report.add("nearest_cables", json_of(room.cables), room.cables.words());
    report.add("nearest_to_grip", json_of(room.grip), room.grip.words());
    report.add("interference", !touching.empty(), touching);
    report.print(options.json);
    return why.empty() && touching.empty() ? 0 : 1;
}

/// Eight lengths of six freedoms need not fit together. What rounding to tenths of a millimetre does is allowed.
void require_fit(const Forward& found) {
    constexpr double most_m = 1e-3;
    if (found.mismatch_m > most_m)
        throw impossible("lengths",
                         fmt::format("no pose has these lengths: the nearest one found misses them by {:.1f} mm "
                                     "(root mean square), {:g} mm is allowed; check them and their order, "
                                     "which is that of the frame's corners, or begin the search nearer to "
                                     "the pose",
                                     found.mismatch_m * 1e3, most_m * 1e3),
                         {"position", "angles"});
}

int direct(const RobotOptions& options) {
    const Geometry geometry = geometry_of(options);
    PerCable lengths;
    for (int i = 0; i < cable_count; ++i) lengths[i] = options.lengths_mm[static_cast<std::size_t>(i)] * 1e-3;
    const Forward found = forward(geometry, lengths, pose_from(options));
    require_fit(found);
    const Vector3 angles = angles_xyz(found.pose.rotation) / degree;
    Report report;
    report.add("position_mm", list(found.pose.position, 1e3), "position / mm: " + words(found.pose.position, 1e3, 4));
    report.add("angles_deg", list(angles), "angles / deg:  " + words(angles, 1.0, 4));
    report.add("steps", found.steps);
    report.add("mismatch_mm", rounded(found.mismatch_m * 1e3),
               fmt::format("{} steps; the lengths fit the pose to {:.4f} mm", found.steps, found.mismatch_m * 1e3));
    report.print(options.json);
    return 0;
}

int tension(const RobotOptions& options) {
    const Geometry geometry = geometry_of(options);
    const robot::Pose pose = pose_from(options);
    if (const std::string why = out_of_length(geometry, cable_lengths(geometry, pose)); !why.empty())
        throw impossible("position", why);
    if (const std::string why = interference(geometry, pose); !why.empty())
        throw impossible("position", why + "; see haptogram robot ik");
    Report report;
    if (options.largest) {
        ordered_json json = ordered_json::object();
        for (const auto& [name, axis, sign] :
             {std::tuple("+x", 0, 1.0), std::tuple("-x", 0, -1.0), std::tuple("+y", 1, 1.0), std::tuple("-y", 1, -1.0),
              std::tuple("+z", 2, 1.0), std::tuple("-z", 2, -1.0)}) {
            Wrench direction = Wrench::Zero();
            direction[axis] = sign;
            const auto most = largest_wrench(geometry, pose, direction);
            if (!most) throw impossible("position", "the cables cannot hold the handle's own weight there");
            json[name] = rounded(*most);
            report.tell(fmt::format("largest force of a user along {}: {:.3f} N", name, *most));
        }
        report.add("largest_n", json);
    } else {
        Wrench wrench;
        wrench << three("force", options.force, "N"), three("torque", options.torque, "N·m");
        const auto found = distribute(structure_of(geometry, pose), geometry.weight() + wrench, geometry.least_n,
                                      geometry.most_n, choice_of(options.choice));
        if (!found)
            throw impossible("force", fmt::format("no tensions from {:g} to {:g} N balance it there; see --largest",
                                                  geometry.least_n, geometry.most_n));
        report.add("tensions_n", list(found->tensions), "tensions / N: " + words(found->tensions, 1.0, 4));
        report.add("within_limits", found->within_limits,
                   found->within_limits ? ""
                                        : fmt::format("the largest, {:.2f} N, is above the limit of {:g} N",
                                                      found->tensions.maxCoeff(), geometry.most_n));
        report.print(options.json);
        return found->within_limits ? 0 : 1;
    }
    report.print(options.json);
    return 0;
}

int reach(const RobotOptions& options) {
    const Geometry geometry = geometry_of(options);
    if (!options.output.empty()) check_output_path(options.output);
    const Workspace found = [&] {
        ProgressLine progress("workspace");
        return workspace(geometry, options.step_mm * 1e-3, turns_of(options.turns), options.angle_deg * degree,
                         progress.callback());
    }();
    if (found.useful.empty())
        throw bad_argument("step", fmt::format("no point of a grid of {:g} mm lies in the frame; take a smaller step",
                                               options.step_mm));
    const double volume = found.volume_m3() * 1e9;
    const std::string turns = options.turns == "none"
                                  ? std::string("upright")
                                  : fmt::format("±{:g}° about {}", options.angle_deg,
                                                options.turns == "one" ? "one axis at a time" : "all axes at once");
    Report report;
    report.add("robot", geometry.name).add("frame_mm", list(geometry.frame, 1e3));
    report.add("points", found.useful.size()).add("useful", found.count);
    report.add("volume_mm3", rounded(volume, 1.0),
               fmt::format("{} of {} cubes of {:g} mm are useful, {}: {:.3e} mm3", found.count, found.useful.size(),
                           options.step_mm, turns, volume));
    report.add("ball_radius_mm", rounded(found.ball_radius_m() * 1e3),
               fmt::format("a ball of that volume has a radius of {:.1f} mm", found.ball_radius_m() * 1e3));
    if (!options.output.empty())
        write_workspace(
            options.output, found,
            fmt::format("{}, frame {:g} × {:g} × {:g} mm, {}: {:.3e} mm³", geometry.name, geometry.frame.x() * 1e3,
                        geometry.frame.y() * 1e3, geometry.frame.z() * 1e3, turns, volume));
    if (options.output != "-") report.print(options.json);
    return 0;
}

int simulate(const RobotOptions& options) {
    SimulationOptions simulation;
    simulation.geometry = geometry_of(options);
    simulation.start = pose_from(options);
    simulation.duration_s = options.duration_s;
    simulation.plant.seed = options.seed;
    for (const std::string& fault : options.faults) {
        simulation.faults.push_back(parse_fault(fault));
        require_within("fault", fault, simulation.faults.back().time_s, options.duration_s);
    }
    std::vector<robot::Push> pushes;
    for (const std::string& push : options.pushes) {
        pushes.push_back(parse_push(push));
        require_within("push", push, pushes.back().from_s, options.duration_s);
    }
    simulation.user = options.wander_mm > 0.0 ? wandering_user({}, options.wander_mm * 1e-3, options.seed)
                                              : pushing_user(std::move(pushes));
    if (!options.output.empty()) check_output_path(options.output);
    const Simulation found = [&] {
        ProgressLine progress("simulate");
        return robot::simulate(simulation, progress.callback());
    }();
    if (!options.output.empty()) write_trace(options.output, found, simulation.controller.admittance.zones);
    Report report;
    const Vector3 end = found.rows.empty() ? simulation.start.position : found.rows.back().position;
    ordered_json events = ordered_json::array();
    for (const Event& event : found.events) {
        events.push_back({{"time_s", rounded(event.time_s)}, {"kind", name_of(event.kind)}, {"text", event.text}});
        if (event.cable >= 0) events.back()["cable"] = event.cable + 1;
        report.tell(fmt::format("{:8.3f} s  {}: {}", event.time_s, name_of(event.kind), event.text));
    }
    report.add("events", events);
    report.add("end_mm", list(end, 1e3), "the handle ends at / mm: " + words(end, 1e3, 3));
    report.add("steadiness_mm", rounded(found.steadiness_m * 1e3),
               fmt::format("in the last second its places lie within {:.3f} mm", found.steadiness_m * 1e3));
    report.add("least_tension_n", list(found.least_n));
    report.add("most_tension_n", list(found.most_n),
               fmt::format("tensions from {:.3f} to {:.3f} N", found.least_n.minCoeff(), found.most_n.maxCoeff()));
    if (const double most = found.most_n.maxCoeff(); most > simulation.geometry.most_n)
        report.tell(fmt::format("the motors yield at {:g} N; cables that were jerked had up to {:.1f} N",
                                simulation.geometry.most_n, most));
    report.add("most_off_mm", rounded(found.most_off_m * 1e3),
               fmt::format("the handle was up to {:.1f} mm from where it was wanted", found.most_off_m * 1e3));
    const double most_turn_deg = found.most_turn_rad / degree;
    report.add("most_turn_deg", rounded(most_turn_deg),
               fmt::format("and turned by up to {:.1f} degrees{}", most_turn_deg,
                           most_turn_deg > 90.0 ? ": it turned over" : ""));
    report.add("nearest", json_of(found.nearest),
               fmt::format("least room, at {:.3f} s: {}", found.nearest_s, found.nearest.words()));
    report.add("interference_s", rounded(found.touched_s),
               found.touched_s == 0.0
                   ? ""
                   : fmt::format("cables touched each other or the grip for {:.3f} s, which the plant does not feel",
                                 found.touched_s));
    report.add("saturated", found.saturated,
               found.saturated == 0 ? "" : fmt::format("{} torque codes were beyond the converter", found.saturated));
    if (options.output != "-") report.print(options.json);
    return found.events.empty() && found.touched_s == 0.0 ? 0 : 1;
}

/// A subcommand of `robot` with the options that all have.
CLI::App* add(CLI::App& robot, const std::string& name, const std::string& about,
              const std::shared_ptr<RobotOptions>& options, Action& action, int (*work)(const RobotOptions&)) {
    CLI::App* sub = robot.add_subcommand(name, about);
    sub->add_option("--robot", options->robot, "Shipped robot, or a robot file (.toml)")->capture_default_str();
    sub->add_option("--edge", options->edge_mm, "A cubic frame of this edge, mm, in place of the robot's own")
        ->check(positive());
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->callback([options, &action, work] { action = [options, work] { return work(*options); }; });
    return sub;
}

void add_pose(CLI::App& sub, const std::shared_ptr<RobotOptions>& options, const std::string& whose) {
    sub.add_option("--position", options->position, "x,y,z of " + whose + ", mm from the frame's centre")
        ->capture_default_str();
    sub.add_option("--angles", options->angles, "Its turns about the fixed x, then y, then z axis, degrees")
        ->capture_default_str();
}

}  // namespace

void add_robot(CLI::App& app, Action& action) {
    CLI::App* robot =
        app.add_subcommand("robot", "A handle on eight cables: kinematics, tensions, workspace, simulation");
    robot->callback([robot, &action] {
        if (robot->get_subcommands().empty())
            action = []() -> int {
                throw Error(ErrorCode::bad_argument, "robot",
                            "expected a subcommand: ik, fk, tension, workspace, simulate, place, explore or tell; see "
                            "haptogram robot --help");
            };
    });
    const auto options = std::make_shared<RobotOptions>();

    CLI::App* ik = add(
        *robot, "ik",
        "The cables' lengths for a pose, and their least distances; exit code 1 when lengths are out of their limits, "
        "or cables touch",
        options, action, inverse);
    add_pose(*ik, options, "the handle");

    CLI::App* fk = add(*robot, "fk", "The pose for the cables' lengths", options, action, direct);
    fk->add_option("lengths", options->lengths_mm, "Eight lengths, mm")
        ->required()
        ->expected(cable_count)
        ->check(positive());
    add_pose(*fk, options, "where the search begins");

    CLI::App* tensions =
        add(*robot, "tension", "Tensions that hold the handle and a force of the user", options, action, tension);
    add_pose(*tensions, options, "the handle");
    auto* force = tensions->add_option("--force", options->force, "Force of the user: x,y,z, N")->capture_default_str();
    auto* torque =
        tensions->add_option("--torque", options->torque, "Torque of the user: x,y,z, N m")->capture_default_str();
    auto* choice = tensions
                       ->add_option("--choice", options->choice,
                                    "norm, sum: the least; centroid: farthest from the limits; paper: eq. 16 of "
                                    "doi:10.1109/JSEN.2022.3144888, which knows no upper limit")
                       ->check(CLI::IsMember({"norm", "sum", "centroid", "paper"}))
                       ->capture_default_str();
    tensions->add_flag("--largest", options->largest, "The largest forces that can be held, instead")
        ->excludes(force)
        ->excludes(torque)
        ->excludes(choice);

    CLI::App* workspace =
        add(*robot, "workspace", "Where the handle can be held at every turn", options, action, reach);
    workspace->add_option("--step", options->step_mm, "Between points, mm")->check(positive())->capture_default_str();
    workspace->add_option("--angle", options->angle_deg, "Angle of the turns, degrees")
        ->check(not_negative())
        ->capture_default_str();
    workspace
        ->add_option("--turns", options->turns, "none: upright; one: about one axis at a time; all: every combination")
        ->check(CLI::IsMember({"none", "one", "all"}))
        ->capture_default_str();
    workspace->add_option("-o,--output", options->output, "A .csv or .png file; - is CSV on standard output");

    CLI::App* run = add(*robot, "simulate",
                        "The controlled robot with a user, on a simulated plant; exit code 1 when it noticed a fault, "
                        "or cables touched",
                        options, action, simulate);
    add_pose(*run, options, "where the handle starts");
    run->add_option("--duration", options->duration_s, "s")->check(positive())->capture_default_str();
    auto* push =
        run->add_option("--push", options->pushes, "FROM:TO:X,Y,Z: a force of the user, s and N; may be repeated");
    run->add_option("--wander", options->wander_mm,
                    "A hand (0.5 kg, 5 N s/m, 100 N/m) that wants random places in a ball of this radius, mm")
        ->check(positive())
        ->excludes(push);
    run->add_option("--fault", options->faults,
                    "KIND:CABLE:TIME: broken, slip (by 5 mm), lost or frozen; cables from 1; may be repeated");
    run->add_option("--seed", options->seed, "Seed of the noise and of the hand")->capture_default_str();
    run->add_option("-o,--output", options->output, "The trace as .csv or .png; - is CSV on standard output");

    add_robot_place(*robot, action);
    add_robot_explore(*robot, action);
    add_robot_tell(*robot, action);
}

void register_robot(Extras& extras) { extras.commands[Purpose::hands].push_back(add_robot); }

}  // namespace haptogram::cli
