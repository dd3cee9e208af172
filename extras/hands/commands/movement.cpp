// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/movement.hpp"

#include <fmt/format.h>

#include <memory>
#include <numbers>

#include "command.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/verbs/source.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct MovementCommand {
    std::string movement, center = "0,0,200";
    double size_mm = 50.0, spacing_mm = 0.5, direction_deg = 90.0, hop_ms = 10.0;
    bool grid = false, json = false;
    MovementOptions movement_options;
    std::optional<std::string> am, am_law, array, board;
    std::string output;
    std::vector<std::string> given;  ///< options on the command line
};

int movement(const MovementCommand& command) {
    const std::vector<std::string_view> curves = {"line", "circle", "spiral"};
    require_effect(command.given,
                   {{"--direction", {"line"}},
                    {"--turns", {"spiral"}},
                    {"--speed", curves},
                    {"--spacing", curves},
                    {"--hop", {"random"}},
                    {"--seconds", {"random"}},
                    {"--seed", {"random"}}},
                   command.movement, "the movement");
    MovementRequest request;
    request.movement = command.movement;
    request.array = command.array;
    request.board = command.board;
    request.grid = command.grid;
    request.am = command.am.value_or(request.am);
    request.am_law = law_of(command.am_law.value_or("pressure"));
    request.options = command.movement_options;
    request.options.centre = parse_point_mm("center", command.center);
    request.options.size_m = command.size_mm * millimetre;
    request.options.spacing_m = command.spacing_mm * millimetre;
    request.options.direction_rad = command.direction_deg * std::numbers::pi / 180.0;
    request.options.hop_s = command.hop_ms * 1e-3;
    const MovementOnArray moved = haptogram::movement(request);
    const MadeMovement& made = moved.made;
    write_file(command.output, to_json_text(made.path, moved.carrier_hz));
    if (command.output == "-") return 0;
    Report report;
    report.add("movement", command.movement, fmt::format("movement          {}", command.movement));
    report.add("array", moved.array.name, fmt::format("array             {}", moved.array.name));
    report.add("steps", made.path.steps.size(),
               fmt::format("path              {} steps at {} places, {:.4g} s, {}", made.path.steps.size(),
                           moved.places, moved.seconds(), command.output));
    report.add("places", moved.places).add("seconds", moved.seconds());
    report.add("length_mm", made.length_m / millimetre,
               made.speed_m_s > 0.0 ? fmt::format("drawn             {:.1f} mm at {:.4g} mm/s",
                                                  made.length_m / millimetre, made.speed_m_s / millimetre)
                                    : fmt::format("hops              {:.1f} mm in all", made.length_m / millimetre));
    report.add("speed_m_s", made.speed_m_s);
    report.print(command.json);
    return 0;
}

}  // namespace

void add_movement(CLI::App& app, Action& action) {
    auto options = std::make_shared<MovementCommand>();
    CLI::App* sub = app.add_subcommand(
        "movement", "A modulated focus that moves over the palm as in Hoshi et al. 2010: a path for compile");
    sub->add_option("movement", options->movement, "line, circle, spiral (outwards) or random (hops)")->required();
    sub->add_option("--size", options->size_mm,
                    "Length of the line, diameter of circle and spiral, edge of the square of random places, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--center", options->center, "x,y,z mm")->capture_default_str();
    sub->add_option("--direction", options->direction_deg, "Direction of the line: degrees from x towards y")
        ->capture_default_str();
    MovementOptions& m = options->movement_options;
    sub->add_option("--turns", m.turns, "Turns of the spiral")->check(positive())->capture_default_str();
    sub->add_option("--speed", m.speed_m_s, "Speed along line, circle and spiral, m/s")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--spacing", options->spacing_mm, "Largest distance from one place to the next, mm")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--hop", options->hop_ms, "With random: time at each place, ms")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--seconds", m.seconds, "With random: before the hops begin again")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("--seed", m.seed, "Seed of the random places")->check(whole(0, UINT64_MAX))->capture_default_str();
    sub->add_flag("--grid", options->grid,
                  "Only the device's positions: 18 x 18, 10 mm apart, at the height of the center");
    add_am(*sub, options->am, options->am_law);
    sub->get_option("--am")->default_str("square:200");
    sub->add_option("--array", options->array, "Array file or shipped array; by default the board's, or tile-10x10");
    sub->add_option("--board", options->board, "Board file, shipped board or configuration");
    sub->add_flag("--json", options->json, "Print as JSON");
    sub->add_option("-o,--output", options->output, "The path, .json; - is standard output")->required();
    sub->callback([sub, options, &action] {
        options->given = given_to(*sub);
        action = [options] { return movement(*options); };
    });
}

}  // namespace haptogram::cli
