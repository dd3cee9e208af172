// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/path_magnitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/render/single_waveform.hpp"

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

PathMagnitude give_magnitude(Path& path, const Tables& tables, const Wanted& wanted, const Array& array) {
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
                try {
                    at->second = setting_for(tables, wanted, array, focus.position).command;
                } catch (const Error& error) {
                    const Vec3& p = focus.position;
                    throw bad_argument(error.where() == "focus" ? "magnitude" : error.where(),
                                       fmt::format("at ({:.1f}, {:.1f}, {:.1f}) mm: {}", p.x / millimetre,
                                                   p.y / millimetre, p.z / millimetre, error.message()),
                                       error.remedies());
                }
                made.least_command = std::min(made.least_command, at->second);
                made.most_command = std::max(made.most_command, at->second);
            }
            focus.amplitude *= at->second;
        }
    }
    made.moves = commands.size() > 1;
    return made;
}

}  // namespace haptogram::perception
