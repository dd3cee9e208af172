// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/hand/mounting.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/verbs/analyze.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

const std::vector<std::string> finger_names = {"thumb", "index", "middle", "ring", "pinkie"};

// Ten touches with 1 mm of noise shall be better than this, and a mounting that is needs no more of them.
constexpr double goal_m = 1e-3, goal_deg = 0.5;
constexpr double to_deg = 180.0 / std::numbers::pi;
constexpr std::size_t most_touches = 100;

struct AlignCommand {
    std::string points, hands, output, finger = "index", array = "tile-10x10";
    std::size_t ask = 0;
    double still_s = 0.7, noise_mm = 1.0;
    bool json = false;
};

/// Where the array can be felt, of the box in which live looks for hands.
std::vector<Vec3> places_of(const std::string& array) {
    constexpr double step_m = 30e-3, half_m = 150e-3, low_m = 20e-3;
    Grid grid;
    for (int i = 0; i <= 10; ++i) {
        grid.x.push_back(i * step_m - half_m);
        grid.z.push_back(i * step_m + low_m);
    }
    grid.y = grid.x;
    return felt_places(find_array(array), grid, least_felt_n);
}

bool is_enough(const Sureness& sure) { return sure.place_m <= goal_m && sure.angle_rad * to_deg <= goal_deg; }

/// Adds places to touch until there are so many, or, where the noise was learned from touches, enough.
Sureness ask_for(std::vector<Vec3>& touched, const std::vector<Vec3>& places, std::size_t most, double noise_m,
                 bool learned) {
    constexpr std::size_t least = 3;
    const auto sure = [&] {
        return touched.size() < least ? Sureness{HUGE_VAL, HUGE_VAL} : sureness_of(touched, noise_m, learned);
    };
    while (touched.size() < most && !(learned && is_enough(sure()))) touched.push_back(next_touch(touched, places));
    return sure();
}

std::string in_words(const Sureness& sure) {
    return fmt::format("{:.2f} mm in their middle and {:.2f} degrees", sure.place_m / millimetre,
                       sure.angle_rad * to_deg);
}

std::string in_mm(Vec3 p) {
    return fmt::format("{:g} {:g} {:g}", p.x / millimetre, p.y / millimetre, p.z / millimetre);
}

/// Where to touch, for a mounting that is not known yet.
int ask_for_touches(const AlignCommand& command) {
    const std::vector<Vec3> places = places_of(command.array);
    if (places.size() < command.ask)
        throw bad_argument("ask", fmt::format("found {}, and {} is felt at {} places of a grid of 30 mm", command.ask,
                                              command.array, places.size()));
    std::vector<Vec3> touches;
    const double noise_m = command.noise_mm * millimetre / std::sqrt(3.0);
    const Sureness sure = ask_for(touches, places, command.ask, noise_m, false);
    const std::string sentence =
        fmt::format("{} places, from which a tracker with {:g} mm of noise is found within {}, in 95 of 100 cases",
                    touches.size(), command.noise_mm, in_words(sure));
    std::string text = "# " + sentence + "\n";
    nlohmann::ordered_json listed = nlohmann::ordered_json::array();
    for (const Vec3 place : touches) {
        text += in_mm(place) + "\n";
        listed.push_back({place.x / millimetre, place.y / millimetre, place.z / millimetre});
    }
    write_file(command.output, text);
    Report report;
    report.add("points", touches.size())
        .add("within_mm", sure.place_m / millimetre)
        .add("within_deg", sure.angle_rad * to_deg)
        .add("places_mm", listed)
        .add("places", command.output, sentence);
    if (command.output != "-") report.print(command.json);
    return 0;
}

std::vector<SeenPoint> points_of(const AlignCommand& command) {
    const std::string text = read_file(command.points);
    if (command.hands.empty()) return seen_points_from(text, command.points);
    const std::vector<Vec3> known = known_points_from(text, command.points);
    const auto finger =
        static_cast<std::size_t>(std::ranges::find(finger_names, command.finger) - finger_names.begin());
    const std::vector<Vec3> touches = touches_in(open_hands(command.hands), finger, command.still_s);
    if (touches.size() != known.size())
        throw bad_input(
            command.hands,
            fmt::format("the tip of the {} stayed {} times for {} s, and {} has {} points; touch each once, "
                        "in their order, and keep still, or change --still",
                        command.finger, touches.size(), command.still_s, command.points, known.size()));
    std::vector<SeenPoint> points;
    for (std::size_t i = 0; i < known.size(); ++i) points.push_back({known[i], touches[i]});
    return points;
}

/// A touch that is far from where the others say that it was.
std::optional<std::size_t> outlier_of(const Alignment& found) {
    constexpr double times = 4.0, least_m = 3e-3;
    std::vector<double> ordered = found.residuals_without_m;
    const auto middle = ordered.begin() + static_cast<std::ptrdiff_t>(ordered.size() / 2);
    std::ranges::nth_element(ordered, middle);
    const auto worst = std::ranges::max_element(found.residuals_without_m);
    if (*worst < least_m || *worst < times * *middle) return {};
    return static_cast<std::size_t>(worst - found.residuals_without_m.begin());
}

/// Whether the touches are enough, and if not, which others would be.
void tell_next(Report& report, const AlignCommand& command, std::vector<Vec3> touched, double noise_m,
               const Sureness& sure) {
    report.add("enough", is_enough(sure));
    if (is_enough(sure)) return;
    const std::size_t before = touched.size();
    const std::vector<Vec3> places = places_of(command.array);
    const std::size_t most = before + std::min(most_touches, places.size() / 2);
    const Sureness then = ask_for(touched, places, most, noise_m, true);
    nlohmann::ordered_json next = nlohmann::ordered_json::array();
    std::string line = is_enough(then)
                           ? fmt::format("next touches, with which it would be right within {} (mm):", in_words(then))
                           : fmt::format(
                                 "next touches; the tracker's noise is so large that {} more are not enough "
                                 "(mm):",
                                 touched.size() - before);
    for (std::size_t i = before; i < touched.size(); ++i) {
        next.push_back({touched[i].x / millimetre, touched[i].y / millimetre, touched[i].z / millimetre});
        if (i < before + 10) line += (i > before ? "; " : " ") + in_mm(touched[i]);
    }
    report.add("next_mm", next, line);
}

int align_tracker(const AlignCommand& command) {
    if (command.points.empty()) throw bad_argument("points", "is missing; --ask 10 makes a list of places to touch");
    const std::vector<SeenPoint> points = points_of(command);
    const Alignment found = align(points, command.hands.empty() ? command.points : command.hands);
    std::vector<double> residuals_mm;
    for (const double residual_m : found.residuals_m) residuals_mm.push_back(residual_m / millimetre);
    std::vector<Vec3> known;
    for (const SeenPoint& point : points) known.push_back(point.known);
    std::optional<Sureness> sure;
    if (found.noise_m) sure = sureness_of(known, *found.noise_m, true);
    const std::string errors = sure ? fmt::format("in 95 of 100 cases right within {}", in_words(*sure))
                                    : "three points tell nothing of errors; take more";
    const std::string sentence = fmt::format("{} points, which it misses by {:.2f} mm (rms); {}", points.size(),
                                             found.rms_m / millimetre, errors);
    write_file(command.output, mounting_to_toml(found.pose, {"A tracker's mounting, by haptogram align: " + sentence}));
    Report report;
    report.add("points", points.size())
        .add("rms_mm", found.rms_m / millimetre)
        .add("within_mm", sure ? nlohmann::ordered_json(sure->place_m / millimetre) : nullptr)
        .add("within_deg", sure ? nlohmann::ordered_json(sure->angle_rad * to_deg) : nullptr)
        .add("residuals_mm", residuals_mm)
        .add("mounting", command.output, sentence);
    if (sure) tell_next(report, command, known, *found.noise_m, *sure);
    if (const auto worst = outlier_of(found)) {
        report.add("outlier", *worst + 1);
        complain(
            fmt::format("warning: point {} is {:.1f} mm from where the others put it; touch it again, or leave it "
                        "out",
                        *worst + 1, found.residuals_without_m[*worst] / millimetre));
    }
    if (command.output != "-") report.print(command.json);
    return 0;
}

}  // namespace

void add_align(CLI::App& app, Action& action) {
    auto options = std::make_shared<AlignCommand>();
    CLI::App* sub = app.add_subcommand(
        "align",
        "Where a tracker or a camera is, from points whose places are known: which a finger has touched, or "
        "which both have measured");
    sub->add_option(
        "points", options->points,
        "Lines 'x y z' in mm, array frame, in the order of touches; without hands lines 'x y z x y z': what is "
        "known, and what the tracker or the camera saw, in its own frame");
    sub->add_option("hands", options->hands, "A recording of a hand that touches them, as render takes it");
    sub->add_option("--finger", options->finger, "Finger whose tip touches")
        ->check(CLI::IsMember(finger_names, CLI::ignore_case))
        ->capture_default_str();
    sub->add_option("--still", options->still_s, "A touch stays within 3 mm for so long, s")
        ->check(positive())
        ->capture_default_str();
    auto* ask =
        sub->add_option("--ask", options->ask,
                        "Instead: write this many places that are good to touch, lines 'x y z', over the array's reach")
            ->check(whole(3, most_touches));
    sub->add_option("--noise", options->noise_mm, "The tracker's noise, mm (rms)")
        ->check(positive())
        ->needs(ask)
        ->capture_default_str();
    sub->add_option("--array", options->array, "Array in whose reach the places to touch are")->capture_default_str();
    sub->add_option("-o,--output", options->output,
                    "The mounting, TOML, for NAME@MOUNTING wherever a recording or a tracker is named; - is standard "
                    "output")
        ->required();
    sub->add_flag("--json", options->json, "The report as JSON on standard output");
    sub->callback([options, sub, &action] {
        require_effect(
            given_to(*sub),
            {{"points", {"touches"}}, {"hands", {"touches"}}, {"--finger", {"touches"}}, {"--still", {"touches"}}},
            options->ask == 0 ? "touches" : "--ask", "what is asked for");
        action = [options] { return options->ask == 0 ? align_tracker(*options) : ask_for_touches(*options); };
    });
}

}  // namespace haptogram::cli
