// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/perception/magnitude.hpp"

namespace haptogram::fusion {

std::size_t places_of(const SharedClock& clock, double frequency_hz) {
    return std::max<std::size_t>(1, static_cast<std::size_t>(frequency_hz * clock.period_s() + 1e-9));
}

Frame FramePen::play(const Stimulus& stimulus) {
    Frame frame;
    frame.magnitude = stimulus.magnitude;
    frame.frequency_hz = stimulus.frequency_hz;
    if (stimulus.points.empty()) {
        frame.path.steps.push_back({{}, clock_.carrier_periods});
        phase_ = 0.0;
        return frame;
    }
    if (stimulus.points.size() > places(stimulus.frequency_hz))
        throw bad_argument("points", fmt::format("a frame of {:g} ms has time for {} points at {:g} Hz, found {}",
                                                 clock_.period_s() * 1e3, places(stimulus.frequency_hz),
                                                 stimulus.frequency_hz, stimulus.points.size()));
    perception::Wanted wanted;
    wanted.magnitude = stimulus.magnitude;
    wanted.frequency_hz = stimulus.frequency_hz;
    wanted.grip_n = grip_n_;
    // What the tables do not know is an error. What this array cannot do at one place is silence there, and counted.
    static_cast<void>(perception::setting_for(tables_, wanted));
    std::vector<std::optional<Focus>> foci;
    for (const Vec3& place : stimulus.points) {
        std::optional<Focus> focus;
        try {
            const perception::Setting setting = perception::setting_for(tables_, wanted, array_, place);
            frame.points.push_back({place, setting});
            focus = Focus{place, setting.command};
        } catch (const Error& error) {
            if (error.where() != "focus" && error.where() != "magnitude") throw;
            if (frame.silent++ == 0) frame.why = error.message();
        }
        foci.push_back(focus);
    }
    constexpr double duty = 0.5, rounding = 1e-9;
    for (std::uint32_t period = 0; period < clock_.carrier_periods; ++period) {
        const double at = phase_ + stimulus.frequency_hz * period / clock_.carrier_hz + rounding;
        const double begun = std::floor(at);
        const auto& turn = foci[static_cast<std::size_t>(begun) % foci.size()];
        PathStep step;
        if (at - begun < duty && turn) step.foci.push_back(*turn);
        if (!frame.path.steps.empty() && frame.path.steps.back().foci == step.foci)
            ++frame.path.steps.back().periods;
        else
            frame.path.steps.push_back(std::move(step));
    }
    phase_ = std::fmod(phase_ + stimulus.frequency_hz * clock_.period_s() + rounding, 1.0) - rounding;
    return frame;
}

double magnitude_of(const perception::Tables& tables, double frequency_hz, const FramePoint& point, double command) {
    return perception::magnitude_of_output(perception::fit_at(tables, frequency_hz),
                                           command * command * point.setting.full_gf / point.setting.factor);
}

}  // namespace haptogram::fusion
