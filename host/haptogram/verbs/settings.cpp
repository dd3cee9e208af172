// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/settings.hpp"

#include <fmt/core.h>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

bool of_shapes(const Project& p) { return p.is_of_shapes(); }
bool is_paced(const Project& p) { return p.pace.speed_m_s || p.pace.frequency_hz; }
bool can_be_paced(const Project& p) { return p.path.empty(); }
bool is_drawn(const Project& p) { return p.hand || (p.is_of_shapes() && is_paced(p)); }
bool is_sampled(const Project& p) {
    return p.hand ? p.hand->frame.has_value() : p.is_of_shapes() || p.path.ends_with(".adaptics");
}
/// Of a hand, lines at random are those of two algorithms.
bool has_chance(const Project& p) {
    return p.hand ? p.hand->algorithm == "E" || p.hand->algorithm == "F" : of_shapes(p);
}

constexpr std::string_view shapes = "shapes";
constexpr Setting of_projects[] = {
    {"--rate", "rate_hz", of_shapes, shapes},
    {"--speed", "speed_m_s", can_be_paced, "shapes and hands"},
    {"--frequency", "frequency_hz", can_be_paced, "shapes and hands"},
    {"--jump", "jump", is_drawn, "shapes that are drawn, by a speed or a frequency, and of hands"},
    {"--even", "even", of_shapes, shapes},
    {"--clip", "clip", of_shapes, shapes},
    {"--center", "place", of_shapes, shapes},
    {"--size", "", of_shapes, shapes},
    {"--rotate", "", of_shapes, shapes},
    {"--scale", "", of_shapes, shapes},
    {"", "shape", of_shapes, shapes},
    {"", "keyframe", of_shapes, shapes},
    {"--points", "points", is_sampled,
     "shapes, of an AdapTics pattern, and of one frame of a hand: add a frame to [hand]"},
    {"--seed", "seed", has_chance, "shapes, and of a hand's algorithms E and F"},
};

std::string_view because(const Project& project) {
    if (!project.path.empty()) return "a path has its own places and times";
    if (project.hand) return "what a hand feels is where the hand meets the object, at a speed or a frequency";
    return "these shapes have neither a speed nor a frequency";  // the one thing that shapes can lack
}

}  // namespace

std::span<const Setting> project_settings() { return of_projects; }

std::string why_idle(std::string_view name, const Project& project) {
    for (const Setting& one : of_projects)
        if (!name.empty() && (name == one.option || name == one.key) && !one.applies(project))
            return fmt::format("is of {}; {}", one.subject, because(project));
    return {};
}

void require_effect(std::span<const std::string> given, const Project& project) {
    for (const std::string& option : given)
        if (const std::string why = why_idle(option, project); !why.empty()) throw bad_argument(option, why);
}

}  // namespace haptogram
