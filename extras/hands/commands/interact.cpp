// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/interaction.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/source.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct InteractCommand {
    std::string content, hand = "synthetic:slide:220", palm = "0,-45,0", scene, output;
    bool grid = false, json = false;
    double noise_px = 0.5, ball_height_mm = 100.0, ball_contact_ms = 30.0, drop_ms = 30.0, creature_mm_s = 30.0,
           palm_radius_mm = 40.0;
    InteractionOptions interaction;
    std::optional<std::string> am, am_law, array, board;
    std::vector<std::string> given;  ///< options on the command line
};

int interact(const InteractCommand& command) {
    require_distinct({{"--hand", command.hand}}, {{"--output", command.output}, {"--scene", command.scene}});
    require_effect(command.given,
                   {{"--ball-height", {"ball"}},
                    {"--ball-contact", {"ball"}},
                    {"--rain", {"rain"}},
                    {"--drop", {"rain"}},
                    {"--creature", {"creature"}}},
                   command.content, "the content");
    if (command.hand.ends_with(".csv")) {
        if (is_among(command.given, "--noise"))
            throw bad_argument("--noise", "is of cameras that see the marker, and its places come from a .csv file");
        require_effect(command.given, {{"--seed", {"rain", "creature"}}}, command.content, "the content");
    }
    InteractionRequest request;
    request.content = command.content;
    request.hand = command.hand;
    request.noise_px = command.noise_px;
    request.grid = command.grid;
    request.am = command.am.value_or(request.am);
    request.am_law = law_of(command.am_law.value_or("pressure"));
    request.array = command.array;
    request.board = command.board;
    request.options = command.interaction;
    request.options.palm_from_marker = parse_point_mm("palm", command.palm);
    request.options.palm_radius_m = command.palm_radius_mm * millimetre;
    request.options.ball_height_m = command.ball_height_mm * millimetre;
    request.options.ball_contact_s = command.ball_contact_ms * 1e-3;
    request.options.drop_s = command.drop_ms * 1e-3;
    request.options.creature_m_s = command.creature_mm_s * millimetre;
    const InteractionOnArray made = haptogram::interact(request);
    const PlayedInteraction& played = made.played;
    const std::string path = to_json_text(played.path, made.carrier_hz);
    if (command.scene.empty())
        write_file(command.output, path);
    else
        write_files({{command.output, path}, {command.scene, to_json_lines(played.scene)}});
    for (const std::string& warning : made.warnings) complain("warning: " + warning);
    if (command.output == "-") return 0;
    Report report;
    report.add("content", command.content, fmt::format("content           {}", command.content));
    report.add("array", made.array.name, fmt::format("array             {}", made.array.name));
    report.add("samples", made.track.samples.size(),
               fmt::format("marker            {} samples, {} unseen", made.track.samples.size(), made.track.unseen));
    report.add("unseen", made.track.unseen);
    report.add("steps", played.path.steps.size(),
               fmt::format("path              {} steps, {:.4g} s, {}", played.path.steps.size(), made.seconds(),
                           command.output));
    report.add("seconds", made.seconds());
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
    sub->add_option("--noise", options->noise_px, "Noise of the marker in each camera's picture, pixels")
        ->check(not_negative())
        ->capture_default_str();
    sub->add_option("--palm", options->palm, "The palm's centre from the marker: x,y,z mm")->capture_default_str();
    sub->add_option("--palm-radius", options->palm_radius_mm, "Radius of the palm, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--ball-height", options->ball_height_mm, "Height above the palm from which the ball falls, mm")
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
    sub->add_option("--creature", options->creature_mm_s, "Speed of the creature, mm/s")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--seed", one.seed, "Seed of rain, creature and noise")
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
    sub->callback([sub, options, &action] {
        options->given = given_to(*sub);
        action = [options] { return interact(*options); };
    });
}

}  // namespace haptogram::cli
