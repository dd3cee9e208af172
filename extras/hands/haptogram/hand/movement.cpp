// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/movement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/hand/feature.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {
namespace {

using std::numbers::pi;

/// The number of the nearest of `count` places, `pitch` apart, the first at `first`.
std::size_t nearest_number(double at, double first, double pitch, std::size_t count) {
    const double number = std::round((at - first) / pitch);
    return static_cast<std::size_t>(std::clamp(number, 0.0, static_cast<double>(count - 1)));
}

double first_of(double centre, double pitch, std::size_t count) {
    return centre - 0.5 * pitch * static_cast<double>(count - 1);
}

/// Length of the spiral r = a·φ from the middle to the angle φ.
double spiral_length(double a, double angle) {
    return 0.5 * a * (angle * std::sqrt(1.0 + angle * angle) + std::asinh(angle));
}

/// The angle at which the spiral has a length, by Newton's method, whose steps only come down from above.
double spiral_angle(double a, double length) {
    double angle = std::sqrt(2.0 * length / a);
    for (int i = 0; i < 60; ++i) {
        const double step = (spiral_length(a, angle) - length) / (a * std::sqrt(1.0 + angle * angle));
        angle -= step;
        if (std::abs(step) <= 1e-13 * (1.0 + angle)) break;
    }
    return angle;
}

double length_of(Movement movement, const MovementOptions& o) {
    if (movement == Movement::line) return o.size_m;
    if (movement == Movement::circle) return pi * o.size_m;
    return spiral_length(0.5 * o.size_m / (2.0 * pi * o.turns), 2.0 * pi * o.turns);
}

/// The place at a length along the curve.
Vec3 place_at(Movement movement, const MovementOptions& o, double length) {
    const auto turned = [&](double radius, double angle) {
        return o.centre + radius * Vec3{std::cos(angle), std::sin(angle), 0.0};
    };
    if (movement == Movement::line) return turned(length - 0.5 * o.size_m, o.direction_rad);
    if (movement == Movement::circle) return turned(0.5 * o.size_m, 2.0 * length / o.size_m);
    const double a = 0.5 * o.size_m / (2.0 * pi * o.turns);
    const double angle = spiral_angle(a, length);
    return turned(a * angle, angle);
}

/// Adds a step, or makes the last one longer when the focus stays.
void add(Path& path, Vec3 position, std::uint32_t periods) {
    if (!path.steps.empty() && path.steps.back().foci.front().position == position)
        path.steps.back().periods += periods;
    else
        path.steps.push_back({{{position}}, periods});
}

}  // namespace

std::vector<Vec3> PositionGrid::positions() const {
    std::vector<Vec3> all;
    all.reserve(layers * rows * columns);
    for (std::size_t layer = 0; layer < layers; ++layer)
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t column = 0; column < columns; ++column)
                all.push_back({first_of(centre.x, pitch_m, columns) + pitch_m * static_cast<double>(column),
                               first_of(centre.y, pitch_m, rows) + pitch_m * static_cast<double>(row),
                               lowest_m + pitch_m * static_cast<double>(layer)});
    return all;
}

Vec3 PositionGrid::nearest(Vec3 point) const {
    const double x = first_of(centre.x, pitch_m, columns), y = first_of(centre.y, pitch_m, rows);
    return {x + pitch_m * static_cast<double>(nearest_number(point.x, x, pitch_m, columns)),
            y + pitch_m * static_cast<double>(nearest_number(point.y, y, pitch_m, rows)),
            lowest_m + pitch_m * static_cast<double>(nearest_number(point.z, lowest_m, pitch_m, layers))};
}

PositionGrid interaction_grid() {
    PositionGrid grid;
    grid.layers = 16;
    grid.lowest_m = 0.15;
    return grid;
}

Movement movement_of(std::string_view name) {
    if (name == "line") return Movement::line;
    if (name == "circle") return Movement::circle;
    if (name == "spiral") return Movement::spiral;
    if (name == "random") return Movement::random;
    throw bad_argument("movement", fmt::format("found \"{}\", expected line, circle, spiral or random", name));
}

MadeMovement movement_path(Movement movement, const MovementOptions& options, double carrier_hz) {
    require_positive("size", options.size_m);
    if (!is_finite(options.centre)) throw bad_argument("center", "a coordinate is not finite; expected numbers");
    const std::uint64_t repetition =
        std::max<std::uint64_t>(1, options.modulation.samples.size() * options.modulation.periods_a_sample);
    MadeMovement made;
    made.path.modulation = options.modulation;
    const auto on_grid = [&](Vec3 place) { return options.grid ? options.grid->nearest(place) : place; };
    if (movement == Movement::random) {
        require_positive("hop", options.hop_s);
        require_positive("seconds", options.seconds);
        const auto periods = static_cast<std::uint32_t>(std::llround(options.hop_s * carrier_hz));
        if (periods == 0)
            throw impossible("hop", fmt::format("{} s are less than half a carrier period; take at least {:.3g} s",
                                                options.hop_s, 1.0 / carrier_hz));
        const auto hops = std::max<std::int64_t>(2, std::llround(options.seconds / options.hop_s));
        KeyedRandom random{static_cast<std::int64_t>(options.seed)};
        const double half = 0.5 * options.size_m;
        std::uint64_t played = 0;
        Vec3 last;
        for (std::int64_t i = 0; i < hops; ++i) {
            const double x = random.uniform(-half, half);
            const Vec3 place = on_grid(options.centre + Vec3{x, random.uniform(-half, half), 0.0});
            if (i > 0) made.length_m += distance(place, last);
            last = place;
            add(made.path, place, periods);
            played += periods;
        }
        // The last hop lasts until the modulation ends.
        made.path.steps.back().periods += static_cast<std::uint32_t>((repetition - played % repetition) % repetition);
        return made;
    }
    require_positive("speed", options.speed_m_s);
    require_positive("spacing", options.spacing_m);
    require_positive("turns", options.turns);
    made.length_m = length_of(movement, options);
    const double wanted = made.length_m / options.speed_m_s * carrier_hz;
    const auto repetitions = std::max<std::int64_t>(1, std::llround(wanted / static_cast<double>(repetition)));
    const std::uint64_t periods = static_cast<std::uint64_t>(repetitions) * repetition;
    const auto count = static_cast<std::uint64_t>(std::max(1.0, std::ceil(made.length_m / options.spacing_m)));
    if (count > periods)
        throw impossible("spacing",
                         fmt::format("{} places in a pass of {} carrier periods, and a focus lasts at least "
                                     "one; take a spacing of at least {:.3g} mm, or a lower speed",
                                     count, periods, made.length_m / static_cast<double>(periods) / millimetre),
                         {"speed"});
    made.speed_m_s = made.length_m / (static_cast<double>(periods) / carrier_hz);
    for (std::uint64_t i = 0; i < count; ++i) {
        // In the middle of its part of the curve. Whole periods are shared out so that none is off by more than one.
        const double at = made.length_m * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
        const std::uint64_t from = i * periods / count, until = (i + 1) * periods / count;
        add(made.path, on_grid(place_at(movement, options, at)), static_cast<std::uint32_t>(until - from));
    }
    return made;
}

MovementOnArray movement(const MovementRequest& request) {
    Project project;
    project.array = request.array;
    project.board = request.board;
    const ProjectInstrument instrument = instrument_of(project);
    MovementOnArray moved;
    moved.array = instrument.array;
    moved.carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    MovementOptions options = request.options;
    if (request.grid) {
        options.grid = PositionGrid{};
        options.grid->lowest_m = options.centre.z;
    }
    options.modulation = modulation_of(request.am, request.am_law, moved.carrier_hz).modulation;
    moved.made = movement_path(movement_of(request.movement), options, moved.carrier_hz);
    require_reachable(moved.made.path, moved.array);
    std::set<std::tuple<double, double, double>> different;
    for (const PathStep& step : moved.made.path.steps) {
        const Vec3 p = step.foci.front().position;
        different.insert({p.x, p.y, p.z});
    }
    moved.places = different.size();
    return moved;
}

}  // namespace haptogram
