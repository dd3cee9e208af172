// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/path_magnitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::perception {
namespace {

std::optional<double> number_in(std::string_view text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

/// What stands before the first colon; the rest goes on after it.
std::string_view take_part(std::string_view& text) {
    const std::size_t colon = text.find(':');
    const std::string_view part = text.substr(0, colon);
    text = colon == std::string_view::npos ? std::string_view() : text.substr(colon + 1);
    return part;
}

}  // namespace

Wanted wanted_of(double magnitude, std::string_view am, bool values_are_radiation) {
    constexpr std::array<std::pair<std::string_view, Waveform>, 5> waveforms = {{{"square", Waveform::square},
                                                                                 {"abs-sine", Waveform::abs_sine},
                                                                                 {"sine", Waveform::sine},
                                                                                 {"triangle", Waveform::triangle},
                                                                                 {"sawtooth", Waveform::sawtooth}}};
    if (values_are_radiation)
        throw bad_argument(
            "magnitude", "is known of waveforms of the pressure, and these are of the radiation pressure", {"am_law"});
    std::string_view rest = am;
    const std::string_view kind = take_part(rest), frequency_text = take_part(rest), duty_text = take_part(rest);
    const auto found = std::find_if(waveforms.begin(), waveforms.end(), [&](const auto& w) { return w.first == kind; });
    const std::optional<double> frequency = number_in(frequency_text);
    const std::optional<double> duty = duty_text.empty() ? 0.5 : number_in(duty_text);
    if (found == waveforms.end() || !frequency || !duty || !rest.empty())
        throw bad_argument("magnitude",
                           fmt::format("is known of one square, sine, abs-sine, triangle or sawtooth wave, such as "
                                       "square:200; the modulation is {}",
                                       am.empty() ? "none" : fmt::format("'{}'", am)),
                           {"am"});
    Wanted wanted;
    wanted.magnitude = magnitude;
    wanted.waveform = found->second;
    wanted.frequency_hz = *frequency;
    wanted.duty = *duty;
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
