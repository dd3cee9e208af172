// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/ring.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

using std::numbers::pi;

/// Length of the ellipse from the end of its minor axis on, towards the major one, up to an angle φ at which the point
/// is (a·sin φ, b·cos φ).
double arc(const Ellipse& e, double eccentricity, double angle) {
    return e.half_major * std::ellint_2(eccentricity, angle);
}

/// The parameter of Ellipse::at() at which a point is nearest to a place.
double nearest_parameter(const Ellipse& e, Vec3 place) {
    constexpr int tried = 720;
    double best = 0.0, least = HUGE_VAL;
    for (int i = 0; i < tried; ++i) {
        const double parameter = 2.0 * pi * i / tried;
        const double way = distance(e.at(parameter), place);
        if (way < least) {
            least = way;
            best = parameter;
        }
    }
    return best;
}

}  // namespace

void require_sound(const RingOptions& options) {
    if (options.points < 3 || options.points > 200)
        throw bad_argument("points of a ring", fmt::format("found {}, expected 3 to 200", options.points));
    if (!(options.turns_hz > 0.0 && options.turns_hz <= 1000.0))
        throw bad_argument("turns",
                           fmt::format("found {} a second, expected more than 0, up to 1000", options.turns_hz));
    const double waves = options.still_am_hz / options.turns_hz;
    if (options.motion == FocusMotion::still && !(waves >= 1.0 && std::abs(waves - std::round(waves)) < 1e-9 &&
                                                  2.0 * waves < static_cast<double>(options.points)))
        throw bad_argument("modulation of the still focus",
                           fmt::format("found {} Hz; expected a multiple of {} Hz below {} Hz", options.still_am_hz,
                                       options.turns_hz, 0.5 * options.turns_hz * static_cast<double>(options.points)));
    const double step_m = 2.0 * pi * options.press.radius_m / options.press.foci / static_cast<double>(options.points);
    if (options.motion == FocusMotion::pressing &&
        !(options.press.foci >= 1 && options.press.foci <= 16 && options.press.turns_hz > 0.0 &&
          options.press.radius_m > 0.0 && step_m < longest_press_step_m))
        throw bad_argument(
            "pressing foci",
            fmt::format("found {} on a circle of {} mm, {} turns a second in steps of {:.3f} mm; expected 1 to 16, a "
                        "positive radius, turns, and steps below {} mm: take more points or a smaller circle",
                        options.press.foci, 1e3 * options.press.radius_m, options.press.turns_hz, 1e3 * step_m,
                        1e3 * longest_press_step_m));
}

double held_fundamental(const RingOptions& options) {
    const double step = pi * options.still_am_hz / options.turns_hz / static_cast<double>(options.points);
    return std::sin(step) / step;
}

std::vector<Vec3> ring_points(const Ellipse& ellipse, std::size_t count, const std::optional<Vec3>& start) {
    const double ratio = ellipse.half_minor / ellipse.half_major;
    const double eccentricity = std::sqrt(std::max(0.0, 1.0 - ratio * ratio));
    const double whole = ellipse.perimeter();
    // at(π/2 − φ) is (a·sin φ, b·cos φ); as φ falls, the parameter rises.
    double angle = 0.5 * pi - (start ? nearest_parameter(ellipse, *start) : 0.0);
    const double first = arc(ellipse, eccentricity, angle);
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double wanted = first - whole * static_cast<double>(i) / static_cast<double>(count);
        for (int round = 0; round < 20; ++round) {
            const double sine = eccentricity * std::sin(angle);
            const double step = (wanted - arc(ellipse, eccentricity, angle)) / ellipse.half_major /
                                std::sqrt(std::max(1e-12, 1.0 - sine * sine));
            angle += std::clamp(step, -0.5, 0.5);
            if (std::abs(step) < 1e-13) break;
        }
        points.push_back(ellipse.at(0.5 * pi - angle));
    }
    return points;
}

namespace {

/// Adds one finger's pressing foci to a path.
void add_press(Path& path, const Ellipse& section, const std::optional<Vec3>& start, const RingOptions& options) {
    const Vec3 from = start ? *start - section.centre : section.major;
    const double begin = std::atan2(dot(from, section.minor), dot(from, section.major));
    const double apart = 2.0 * pi / options.press.foci;
    for (std::size_t j = 0; j < options.points; ++j)
        for (unsigned k = 0; k < options.press.foci; ++k) {
            const double turn = begin + apart * (k + static_cast<double>(j) / static_cast<double>(options.points));
            path.steps[j].foci.push_back({section.centre + options.press.radius_m * (std::cos(turn) * section.major +
                                                                                     std::sin(turn) * section.minor),
                                          1.0});
        }
}

}  // namespace

Path ring_path(std::span<const Ellipse> sections, std::span<const std::optional<Vec3>> starts, double carrier_hz,
               const RingOptions& options) {
    require_sound(options);
    const double periods = std::round(carrier_hz / options.passes_hz() / static_cast<double>(options.points));
    if (periods < 1.0)
        throw bad_argument("turns", fmt::format("{} points at {} Hz leave less than a carrier period for each",
                                                options.points, options.passes_hz()));
    Path path;
    path.steps.resize(options.points);
    for (std::size_t j = 0; j < options.points; ++j) path.steps[j].periods = static_cast<std::uint32_t>(periods);
    const double waves = options.still_am_hz / options.turns_hz;
    for (std::size_t f = 0; f < sections.size(); ++f) {
        if (options.motion == FocusMotion::revolving) {
            const std::vector<Vec3> points = ring_points(sections[f], options.points, starts[f]);
            for (std::size_t j = 0; j < options.points; ++j) path.steps[j].foci.push_back({points[j], 1.0});
            continue;
        }
        if (options.motion == FocusMotion::pressing) {
            add_press(path, sections[f], starts[f], options);
            continue;
        }
        for (std::size_t j = 0; j < options.points; ++j) {
            const double turn = waves * static_cast<double>(j) / static_cast<double>(options.points);
            const double amplitude = 0.5 - 0.5 * std::cos(2.0 * pi * turn);
            if (amplitude > 0.0) path.steps[j].foci.push_back({sections[f].centre, amplitude});
        }
    }
    return path;
}

}  // namespace haptogram
