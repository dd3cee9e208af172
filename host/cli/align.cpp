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
#include "haptogram/verbs/hand_source.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

const std::vector<std::string> finger_names = {"thumb", "index", "middle", "ring", "pinkie"};

struct AlignCommand {
    std::string points, hands, output, finger = "index";
    double still_s = 0.7;
    bool json = false;
};

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

int align_tracker(const AlignCommand& command) {
    const std::vector<SeenPoint> points = points_of(command);
    const Alignment found = align(points, command.hands.empty() ? command.points : command.hands);
    constexpr double degree = std::numbers::pi / 180.0;
    std::vector<double> residuals_mm;
    for (const double residual_m : found.residuals_m) residuals_mm.push_back(residual_m / millimetre);
    const bool sure = points.size() > 3;
    const std::string errors = sure ? fmt::format("± {:.2f} mm in their middle, ± {:.2f} degrees",
                                                  found.position_m / millimetre, found.angle_rad / degree)
                                    : "three points tell nothing of errors; take more";
    const std::string sentence = fmt::format("{} points, which it misses by {:.2f} mm (rms); {}", points.size(),
                                             found.rms_m / millimetre, errors);
    write_file(command.output, mounting_to_toml(found.pose, {"A tracker's mounting, by haptogram align: " + sentence}));
    Report report;
    report.add("points", points.size())
        .add("rms_mm", found.rms_m / millimetre)
        .add("position_error_mm", sure ? nlohmann::ordered_json(found.position_m / millimetre) : nullptr)
        .add("angle_error_deg", sure ? nlohmann::ordered_json(found.angle_rad / degree) : nullptr)
        .add("residuals_mm", residuals_mm)
        .add("mounting", command.output, sentence);
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
           "known, and what the tracker or the camera saw, in its own frame")
        ->required();
    sub->add_option("hands", options->hands, "A recording of a hand that touches them, as render takes it");
    sub->add_option("--finger", options->finger, "Whose tip touches")
        ->check(CLI::IsMember(finger_names, CLI::ignore_case))
        ->capture_default_str();
    sub->add_option("--still", options->still_s, "For so long a touch stays within 3 mm, s")
        ->check(positive())
        ->capture_default_str();
    sub->add_option("-o,--output", options->output,
                    "The mounting, TOML, for NAME@MOUNTING wherever a recording or a tracker is named; - is standard "
                    "output")
        ->required();
    sub->add_flag("--json", options->json, "The report as JSON on standard output");
    sub->callback([options, &action] { action = [options] { return align_tracker(*options); }; });
}

}  // namespace haptogram::cli
