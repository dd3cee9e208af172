// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/instrument/compile.hpp"
#include "haptogram/instrument/render.hpp"
#include "haptogram/instrument/source.hpp"
#include "haptogram/render/interaction.hpp"
#include "haptogram/render/path_file.hpp"
#include "haptogram/render/shape_path.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

using nlohmann::ordered_json;

struct InteractCommand {
    std::string content, hand = "synthetic:slide:220", palm = "0,-45,0", scene, output;
    bool grid = false, json = false;
    double noise_px = 0.5, ball_height_mm = 100.0, ball_contact_ms = 30.0, drop_ms = 30.0, creature_mm_s = 30.0,
           palm_radius_mm = 40.0;
    InteractionOptions interaction;
    std::optional<std::string> am, am_law, array, board;
};

/// Where a marker is over time: rows of a file, or what the two cameras see of a hand.
MarkerTrack marker_of(const InteractCommand& command, double carrier_hz) {
    if (command.hand.ends_with(".csv")) {
        MarkerTrack track;
        std::uint64_t periods = 0;
        for (const PathStep& step : path_from_csv(read_file(command.hand), command.hand, carrier_hz).steps) {
            if (step.foci.empty())
                ++track.unseen;
            else
                track.samples.push_back({static_cast<double>(periods) / carrier_hz, step.foci.front().position});
            periods += step.periods;
        }
        return track;
    }
    MarkerTracker tracker = usual_tracker();
    tracker.noise_px = command.noise_px;
    tracker.seed = command.interaction.seed;
    return track_marker(open_hands(command.hand), tracker);
}

ordered_json in_mm(Vec3 p) { return {p.x / millimetre, p.y / millimetre, p.z / millimetre}; }

std::string to_json_lines(const std::vector<SceneMoment>& scene) {
    std::string text;
    for (const SceneMoment& moment : scene) {
        ordered_json line = {{"time_s", moment.time_s}, {"things_mm", ordered_json::array()}};
        if (moment.palm) line["palm_mm"] = in_mm(*moment.palm);
        for (const Vec3& thing : moment.things) line["things_mm"].push_back(in_mm(thing));
        if (moment.focus) line["focus_mm"] = in_mm(*moment.focus);
        text += line.dump() + "\n";
    }
    return text;
}

int interact(const InteractCommand& command) {
    require_distinct({{"--hand", command.hand}}, {{"--output", command.output}, {"--scene", command.scene}});
    Project project;
    project.array = command.array;
    project.board = command.board;
    const ProjectInstrument instrument = instrument_of(project);
    const double carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    InteractionOptions options = command.interaction;
    options.palm_from_marker = parse_point_mm("palm", command.palm);
    options.palm_radius_m = command.palm_radius_mm * millimetre;
    options.ball_height_m = command.ball_height_mm * millimetre;
    options.ball_contact_s = command.ball_contact_ms * 1e-3;
    options.drop_s = command.drop_ms * 1e-3;
    options.creature_m_s = command.creature_mm_s * millimetre;
    if (command.grid) options.grid = interaction_grid();
    options.modulation =
        modulation_of(command.am.value_or("square:200"), law_of(command.am_law.value_or("pressure")), carrier_hz)
            .modulation;
    const MarkerTrack track = marker_of(command, carrier_hz);
    const PlayedInteraction played =
        haptogram::interact(content_of(command.content), track.samples, options, carrier_hz);
    if (!(played.felt_s > 0.0))
        throw bad_input(command.hand, fmt::format("nothing touches the palm where the device reaches ({:.3g} s are out "
                                                  "of its reach); move the hand to heights of {:g} to {:g} mm",
                                                  played.out_of_range_s, options.lowest_m / millimetre,
                                                  options.highest_m / millimetre));
    std::vector<Vec3> places;
    for (const PathStep& step : played.path.steps)
        for (const Focus& focus : step.foci) places.push_back(focus.position);
    static_cast<void>(reachable_points(places, instrument.array, false));
    if (command.scene.empty())
        write_file(command.output, to_json_text(played.path, carrier_hz));
    else
        write_files(
            {{command.output, to_json_text(played.path, carrier_hz)}, {command.scene, to_json_lines(played.scene)}});
    if (played.out_of_range_s > 0.0)
        complain(fmt::format("warning: for {:.3g} s the focus would be out of the device's reach, and is silent",
                             played.out_of_range_s));
    if (track.unseen > 0)
        complain(fmt::format("warning: a camera does not see the marker in {} of {} pictures", track.unseen,
                             track.unseen + track.samples.size()));
    if (command.output == "-") return 0;
    const double seconds = static_cast<double>(played.path.periods()) / carrier_hz;
    Report report;
    report.add("content", command.content, fmt::format("content           {}", command.content));
    report.add("array", instrument.array.name, fmt::format("array             {}", instrument.array.name));
    report.add("samples", track.samples.size(),
               fmt::format("marker            {} samples, {} unseen", track.samples.size(), track.unseen));
    report.add("unseen", track.unseen);
    report.add(
        "steps", played.path.steps.size(),
        fmt::format("path              {} steps, {:.4g} s, {}", played.path.steps.size(), seconds, command.output));
    report.add("seconds", seconds);
    report.add("touches", played.touches,
               fmt::format("felt              {} touches, {:.4g} s; {:.4g} s out of reach, {:.4g} s without a hand",
                           played.touches, played.felt_s, played.out_of_range_s, played.lost_s));
    report.add("felt_s", played.felt_s).add("out_of_range_s", played.out_of_range_s).add("lost_s", played.lost_s);
    report.print(command.json);
    return 0;
}

}  // namespace

void add_interact(CLI::App& app, Action& action) {
    auto options = std::make_shared<InteractCommand>();
    CLI::App* sub = app.add_subcommand(
        "interact",
        "Something floats above the array and touches a recorded hand, as in Hoshi et al. 2010: a path for compile");
    sub->add_option("content", options->content,
                    "ball (bounces on the palm), rain (drops on it) or creature (walks on it)")
        ->required();
    sub->add_option(
           "--hand", options->hand,
           "A Leap recording, poses, or synthetic:SCRIPT:HEIGHT, as render takes it, whose marker two simulated "
           "cameras see; or a .csv file of the marker: time_ms, x_mm, y_mm, z_mm")
        ->capture_default_str();
    sub->add_option("--noise", options->noise_px, "Of the marker in each camera's picture, pixels")
        ->check(not_negative())
        ->capture_default_str();
    sub->add_option("--palm", options->palm, "The palm's centre from the marker: x,y,z mm")->capture_default_str();
    sub->add_option("--palm-radius", options->palm_radius_mm, "mm")->check(positive())->capture_default_str();
    sub->add_option("--ball-height", options->ball_height_mm, "Above the palm, from which the ball falls, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--ball-contact", options->ball_contact_ms, "Time that a bounce takes, ms")
        ->check(positive())
        ->capture_default_str();
    InteractionOptions& one = options->interaction;
    sub->add_option("--rain", one.rain_hz, "Drops a second")->check(positive())->capture_default_str();
    sub->add_option("--drop", options->drop_ms, "Time that a drop is felt, ms")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--creature", options->creature_mm_s, "Its speed, mm/s")->check(positive())->capture_default_str();
    sub->add_option("--seed", one.seed, "Of rain, creature and noise")
        ->check(whole(0, UINT64_MAX))
        ->capture_default_str();
    sub->add_flag("--grid", options->grid,
                  "Only the device's positions: 18 x 18, 10 mm apart, at heights from 150 to 300 mm");
    add_am(*sub, options->am, options->am_law);
    sub->get_option("--am")->default_str("square:200");
    sub->add_option("--array", options->array, "Array file or shipped array; by default the board's, or tile-10x10");
    sub->add_option("--board", options->board, "Board file, shipped board or configuration");
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->add_option("--scene", options->scene,
                    "Also write what a display would show, a line of JSON every 10 ms: palm, things, focus");
    sub->add_option("-o,--output", options->output, "The path, .json; - is standard output")->required();
    sub->callback([options, &action] { action = [options] { return interact(*options); }; });
}

}  // namespace haptogram::cli
