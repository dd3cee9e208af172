// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/path_magnitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "haptogram/base/error.hpp"
#include "haptogram/format/single_waveform.hpp"
#include "haptogram/verbs/project.hpp"

namespace haptogram::perception {
Wanted wanted_of(double magnitude, std::string_view am, bool values_are_radiation) {
    if (values_are_radiation)
        throw bad_argument(
            "magnitude", "is known of waveforms of the pressure, and these are of the radiation pressure", {"am_law"});
    const std::optional<NamedWaveform> waveform = single_waveform(am);
    if (!waveform)
        throw bad_argument("magnitude",
                           fmt::format("is known of one square, sine, abs-sine, triangle or sawtooth wave, such as "
                                       "square:200; the modulation is {}",
                                       am.empty() ? "none" : fmt::format("'{}'", am)),
                           {"am"});
    Wanted wanted;
    wanted.magnitude = magnitude;
    wanted.waveform = waveform_of(waveform->kind);
    wanted.frequency_hz = waveform->frequency_hz;
    wanted.duty = waveform->duty;
    return wanted;
}

namespace {

/// The command at a place; an error names the place.
double command_at(const Tables& tables, const Wanted& wanted, const Array& array, Vec3 place) {
    try {
        return setting_for(tables, wanted, array, place).command;
    } catch (const Error& error) {
        throw bad_argument(error.where() == "focus" ? "magnitude" : error.where(),
                           fmt::format("at ({:.1f}, {:.1f}, {:.1f}) mm: {}", place.x / millimetre, place.y / millimetre,
                                       place.z / millimetre, error.message()),
                           error.remedies());
    }
}

/// Multiplies the amplitudes of a path's foci by what `command` says of their places.
template <class Command>
PathMagnitude multiply(Path& path, Command command) {
    const auto before = [](const Vec3& a, const Vec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
    std::map<Vec3, double, decltype(before)> commands(before);
    PathMagnitude made{1.0, 0.0, false};
    for (PathStep& step : path.steps) {
        if (step.foci.size() > 1)
            throw bad_argument("magnitude",
                               fmt::format("is known of one focus at a time, and a step of the path has {} "
                                           "that share the array's pressure",
                                           step.foci.size()));
        for (Focus& focus : step.foci) {
            const auto [at, is_new] = commands.try_emplace(focus.position, 0.0);
            if (is_new) {
                at->second = command(focus.position);
                made.least_command = std::min(made.least_command, at->second);
                made.most_command = std::max(made.most_command, at->second);
            }
            focus.amplitude *= at->second;
        }
    }
    made.moves = commands.size() > 1;
    return made;
}

constexpr double pitch_m = 5e-3;  // of the lattice

}  // namespace

PathMagnitude give_magnitude(Path& path, const Tables& tables, const Wanted& wanted, const Array& array) {
    return multiply(path, [&](Vec3 place) { return command_at(tables, wanted, array, place); });
}

CommandLattice::CommandLattice(const Tables& tables, const Wanted& wanted, const Array& array)
    : tables_(tables), wanted_(wanted), array_(array), needed_gf_(needed_gf(tables, wanted)) {}

double CommandLattice::force_at(const std::array<long, 3>& corner) {
    const auto [at, is_new] = forces_.try_emplace(corner, std::numeric_limits<double>::quiet_NaN());
    if (is_new) {
        const auto along = [&](std::size_t axis) { return pitch_m * static_cast<double>(corner[axis]); };
        const Vec3 place{along(0), along(1), along(2)};
        if (array_.unreachable(place).empty()) at->second = full_force(array_, place);
    }
    return at->second;
}

double CommandLattice::at(Vec3 place) {
    if (!array_.unreachable(place).empty()) return command_at(tables_, wanted_, array_, place);  // which says why
    const std::array<double, 3> lattice = {place.x / pitch_m, place.y / pitch_m, place.z / pitch_m};
    double force = 0.0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        std::array<long, 3> number{};
        double weight = 1.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = std::floor(lattice[axis]), part = lattice[axis] - low;
            const bool upper = (corner >> axis & 1U) != 0;
            number[axis] = static_cast<long>(low) + (upper ? 1 : 0);
            weight *= upper ? part : 1.0 - part;
        }
        if (weight > 0.0) force += weight * force_at(number);
    }
    const double full_gf = mean_output(Waveform::square) * force / gram_force_n;
    // At the edge of what the array can do, and where a corner is out of its reach, the place itself decides.
    if (!(needed_gf_ <= 0.98 * full_gf)) return command_at(tables_, wanted_, array_, place);
    return std::sqrt(needed_gf_ / full_gf);
}

PathMagnitude give_magnitude(Path& path, CommandLattice& commands) {
    return multiply(path, [&](Vec3 place) { return commands.at(place); });
}

PathMagnitude give_magnitude(Path& path, const Project& project, const Array& array) {
    const Wanted wanted = wanted_of(project.magnitude.value(), project.am, project.am_law == AmplitudeLaw::radiation);
    return give_magnitude(path, find_tables(), wanted, array);
}

}  // namespace haptogram::perception
