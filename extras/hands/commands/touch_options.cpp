// SPDX-License-Identifier: Apache-2.0
#include "touch_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "haptogram/hand/feature.hpp"
#include "object_options.hpp"

namespace haptogram::cli {

void add_touch_options(CLI::App& sub, TouchArguments& arguments) {
    TouchOptions& touch = arguments.touch;
    auto* speed = sub.add_option("--speed", arguments.speed_m_s,
                                 fmt::format("Speed of the focus, m/s (default: {:g}; of K 0.1)", usual_speed_m_s))
                      ->check(positive());
    sub.add_option("--frequency", arguments.frequency_hz,
                   "Passes over all lines a second instead, Hz (default of L: 5)")
        ->check(positive())
        ->excludes(speed);
    sub.add_option("--jump", arguments.jump,
                   "Between lines: hop, which takes no time, or blank, silence for as long as the way takes")
        ->check(CLI::IsMember({"hop", "blank"}))
        ->capture_default_str();
    sub.add_option("--corner", arguments.corner, "With B, H, I, J: what is drawn at a corner")
        ->check(CLI::IsMember({"circle", "pulsing-circle", "rotating-line", "triangle", "random-points"}))
        ->capture_default_str();
    add_mm(sub, "--corner-radius", touch.feature.radius_m, "Radius of circles and random points, mm");
    add_mm(sub, "--corner-line", touch.feature.line_m, "Length of the rotating line, mm");
    add_mm(sub, "--corner-triangle", touch.feature.triangle_m, "Side of the triangle, mm");
    sub.add_flag("--off-skin", arguments.off_skin, "Draw edges and corners where the object has them, not on the skin");
    sub.add_option("--priority", arguments.priority,
                   "With H, I, J: other lines keep a gap from features, or are left out on a finger that has a feature")
        ->check(CLI::IsMember({"gap", "finger"}))
        ->capture_default_str();
    sub.add_option_function<double>(
           "--gap", [&touch](double mm) { touch.gap_m = mm * millimetre; }, "Gap of the rule, mm")
        ->check(not_negative())
        ->default_str(fmt::format("{:g}", touch.gap_m / millimetre));
    sub.add_option("--solid-level", touch.solid_level,
                   "With D, I: the second contour's depth over the deepest point's, 0 to 1")
        ->capture_default_str();
    sub.add_flag("--two-foci", touch.two_foci, "With D: both contours at the same time");
    add_mm(sub, "--grain-spacing", touch.grain.spacing_m,
           "With E and F: a line for each square or cube of this edge, mm");
    add_mm(sub, "--grain-length", touch.grain.length_m, "With E and F: length of a line, mm");
    add_mm(sub, "--blob-finger", touch.blob_finger_m, "With G, J: the largest circle on a fingertip, radius in mm");
    add_mm(sub, "--blob-palm", touch.blob_palm_m, "With G, J: the same on the palm");
    sub.add_option("--am-frequency", touch.am_hz, "Frequency of the modulation in C and K, Hz")
        ->check(positive())
        ->capture_default_str();
    sub.add_option("--wait", touch.pointer_wait_s, "With K: time at each corner, s")
        ->check(not_negative())
        ->capture_default_str();
    add_mm(sub, "--press-radius", touch.press.radius_m, "With L: radius of the circles, mm");
    sub.add_option("--press-foci", touch.press.foci, "With L: foci on each circle")
        ->check(whole(1, 16))
        ->capture_default_str();
}

TouchOptions touch_of(const TouchArguments& arguments, std::uint64_t seed) {
    TouchOptions touch = arguments.touch;
    if (arguments.speed_m_s || arguments.frequency_hz) touch.pace = Pace{arguments.speed_m_s, arguments.frequency_hz};
    touch.jump = arguments.jump == "hop" ? Jump::hop : Jump::blank;
    touch.feature.corner = corner_figure(arguments.corner);
    touch.feature.project = !arguments.off_skin;
    touch.feature.seed = touch.grain.seed = seed;
    touch.priority = arguments.priority == "gap" ? Priority::gap : Priority::finger;
    return touch;
}

void require_touch_effect(const std::vector<std::string>& given, const std::string& algorithm,
                          const TouchArguments& arguments) {
    std::vector<std::string> letters;
    for (const AlgorithmName& one : algorithm_names()) letters.emplace_back(1, one.letter);
    const std::vector<std::string_view> all(letters.begin(), letters.end());
    const std::vector<std::string_view> with_corners = {"B", "H", "I", "J"}, mixed = {"H", "I", "J"};
    require_effect(given,
                   {{"--speed", all},
                    {"--frequency", all},
                    {"--jump", all},
                    {"--corner", with_corners},
                    {"--corner-radius", with_corners},
                    {"--corner-line", with_corners},
                    {"--corner-triangle", with_corners},
                    {"--off-skin", with_corners},
                    {"--priority", mixed},
                    {"--gap", mixed},
                    {"--solid-level", {"D", "I"}},
                    {"--two-foci", {"D"}},
                    {"--grain-spacing", {"E", "F"}},
                    {"--grain-length", {"E", "F"}},
                    {"--blob-finger", {"G", "J"}},
                    {"--blob-palm", {"G", "J"}},
                    {"--am-frequency", {"C", "K"}},
                    {"--wait", {"K"}},
                    {"--press-radius", {"L"}},
                    {"--press-foci", {"L"}},
                    {"--seed", {"B", "E", "F", "H", "I", "J"}}},
                   algorithm, "the algorithm");
    if (std::ranges::find(with_corners, algorithm) != with_corners.end())
        require_effect(given,
                       {{"--corner-radius", {"circle", "pulsing-circle", "random-points"}},
                        {"--corner-line", {"rotating-line"}},
                        {"--corner-triangle", {"triangle"}},
                        {"--seed", {"random-points"}}},
                       arguments.corner, "what is drawn at a corner");
    require_effect(given, {{"--gap", {"gap"}}}, arguments.priority, "the priority");
}

}  // namespace haptogram::cli
