// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/adaptics_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/shape/adaptics_pattern.hpp"

namespace haptogram {

using adaptics::Moment, adaptics::moment_of;

namespace {

bool same(double a, double b) { return std::abs(a - b) <= 1e-9 * std::max({1.0, std::abs(a), std::abs(b)}); }
bool same(const Moment& a, const Moment& b) {
    return same(a.place.x, b.place.x) && same(a.place.y, b.place.y) && same(a.place.z, b.place.z) &&
           same(a.brush.half_x_mm, b.brush.half_x_mm) && same(a.intensity, b.intensity);
}

}  // namespace

AdapticsFrames frames_from_adaptics(std::string_view text, const std::string& where) {
    const adaptics::Pattern pattern = adaptics::read_pattern(text, where, {});
    const auto cannot = [&](const std::string& why) {
        return bad_input(where, fmt::format("key frames of a shape cannot say it: {}", why));
    };
    std::vector<double> times_ms;
    for (const auto& [time_ms, kind] : pattern.frames)
        if (times_ms.empty() || time_ms > times_ms.back()) times_ms.push_back(time_ms);
    std::vector<Moment> moments;
    double widest_mm = 0.0, narrowest_mm = adaptics::largest;
    for (const double time_ms : times_ms) {
        const Moment& now = moments.emplace_back(moment_of(pattern, time_ms, time_ms));
        if (now.brush.line) throw cannot(fmt::format("at {:g} ms its brush is a line", time_ms));
        if (now.brush.am_hz != moments.front().brush.am_hz)
            throw cannot(fmt::format("its strength beats {:g} times a second at first and {:g} times at {:g} ms",
                                     moments.front().brush.am_hz, now.brush.am_hz, time_ms));
        if (!(now.intensity >= 0.0 && now.intensity <= 1.0))
            throw cannot(fmt::format("its intensity is {:g} at {:g} ms, and not from 0 to 1", now.intensity, time_ms));
        widest_mm = std::max(widest_mm, now.brush.half_x_mm);
        narrowest_mm = std::min(narrowest_mm, now.brush.half_x_mm);
    }
    if (narrowest_mm < 0.0 || (narrowest_mm == 0.0 && widest_mm > 0.0))
        throw cannot(fmt::format("its brush is a circle of {:g} mm at one time, and none at another", widest_mm));
    AdapticsFrames found;
    if (widest_mm > 0.0) found.diameter_m = 2.0 * widest_mm * millimetre;
    const Vec3 first = moments.front().place;
    found.centre = from_mm(first.x, first.y, first.z);
    for (std::size_t i = 0; i < moments.size(); ++i) {
        const double time_ms = times_ms[i];
        const auto& [place, brush, intensity] = moments[i];
        KeyFrame frame;
        frame.time_s = (time_ms - times_ms.front()) * 1e-3 / pattern.speed;
        frame.move = from_mm(place.x - first.x, place.y - first.y, place.z - first.z);
        if (widest_mm > 0.0) frame.scale = brush.half_x_mm / widest_mm;
        frame.amplitude = intensity;
        frame.am_hz = brush.am_hz;
        if (i + 1 < moments.size()) {
            const Moment end = moment_of(pattern, time_ms, times_ms[i + 1]);
            const bool stays = same(end, moments[i]);
            if (!stays && !same(end, moments[i + 1]))
                throw cannot(fmt::format("from {:g} ms on one thing changes evenly and another in a step", time_ms));
            if (stays && !same(moments[i], moments[i + 1])) frame.ease = Ease::step;
        }
        found.frames.push_back(frame);
    }
    return found;
}

}  // namespace haptogram
