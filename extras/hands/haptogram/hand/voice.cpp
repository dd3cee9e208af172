// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/voice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"

namespace haptogram {
namespace {

/// A voice and the times at which its legs end.
class Track {
public:
    double am_hz;

    explicit Track(const Voice& voice) : am_hz(voice.am_hz), legs_(voice.legs) {
        for (const Leg& leg : legs_) ends_.push_back((ends_.empty() ? 0.0 : ends_.back()) + leg.seconds);
    }
    [[nodiscard]] double seconds() const { return ends_.empty() ? 0.0 : ends_.back(); }
    /// The leg after a share of the pass, and where on it the focus is.
    [[nodiscard]] std::pair<const Leg*, Vec3> at(double share) const {
        const double time = share * seconds();
        const auto end = std::upper_bound(ends_.begin(), ends_.end() - 1, time);
        const Leg& leg = legs_[static_cast<std::size_t>(end - ends_.begin())];
        const double part = leg.seconds > 0.0 ? std::clamp(1.0 - (*end - time) / leg.seconds, 0.0, 1.0) : 0.0;
        return {&leg, leg.from.position + part * (leg.to.position - leg.from.position)};
    }

private:
    const std::vector<Leg>& legs_;
    std::vector<double> ends_;
};

std::vector<Track> tracks_of(const std::vector<Voice>& voices) {
    std::vector<Track> tracks;
    for (const Voice& voice : voices) {
        tracks.emplace_back(voice);
        if (!(tracks.back().seconds() > 0.0)) tracks.pop_back();
    }
    return tracks;
}

}  // namespace

double Voice::seconds() const {
    double sum = 0.0;
    for (const Leg& leg : legs) sum += leg.seconds;
    return sum;
}

Voice drawn(const std::vector<SkinLine>& lines, const Pace& pace, Jump jump) {
    if (pace.speed_m_s.has_value() == pace.frequency_hz.has_value())
        throw bad_argument("speed", "give either a speed or a frequency", {"speed", "frequency"});
    require_positive(pace.speed_m_s ? "speed" : "frequency", pace.speed_m_s ? *pace.speed_m_s : *pace.frequency_hz);
    Voice voice;
    double way = 0.0;
    const auto add = [&](const SkinPoint& from, const SkinPoint& to, bool silent, std::size_t line) {
        const double length = distance(from.position, to.position);
        if (length == 0.0) return;
        voice.legs.push_back({from, to, length, silent, line});
        way += length;
    };
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const std::vector<SkinPoint> path = opened(lines[i]);
        for (std::size_t k = 1; k < path.size(); ++k) add(path[k - 1], path[k], false, i);
        const SkinLine& next = lines[(i + 1) % lines.size()];
        if (jump == Jump::blank && !path.empty() && !next.points.empty())
            add(path.back(), next.points.front(), true, i);
    }
    const double speed = pace.speed_m_s ? *pace.speed_m_s : *pace.frequency_hz * way;
    for (Leg& leg : voice.legs) leg.seconds /= speed;
    return voice;
}

PathPen::PathPen(const Array& array, double carrier_hz, std::uint32_t dwell)
    : array_(array), carrier_hz_(carrier_hz), dwell_(dwell) {
    if (dwell == 0) throw bad_argument("dwell", "found 0, expected at least 1 carrier period");
}

void PathPen::play_step(const std::vector<Focus>& foci, double periods) {
    // Silence goes on in the step that has begun it.
    if (foci.empty() && !stretches_.empty() && stretches_.back().foci.empty())
        stretches_.back().periods += periods;
    else
        stretches_.push_back({foci, periods});
    at_periods_ += periods;
}

void PathPen::add(std::vector<Focus>& foci, const Leg& leg, Vec3 position, double am_hz, double time_s,
                  Played& played) const {
    if (leg.silent) return;
    ++played.foci;
    if (const std::string why = array_.unreachable(position); !why.empty()) {
        if (++played.out_of_reach == 1) played.why = why;
        return;
    }
    const double amplitude = am_hz > 0.0 ? 0.5 + 0.5 * std::sin(2.0 * std::numbers::pi * am_hz * time_s) : 1.0;
    if (amplitude > 0.0) foci.push_back({position, amplitude});
}

Played PathPen::play(const std::vector<Voice>& voices, double until_s, double amplitude) {
    Played played;
    const double until = until_s * carrier_hz_;
    const std::vector<Track> tracks = tracks_of(voices);
    shares_.resize(std::max(shares_.size(), tracks.size()), 0.0);
    constexpr double rounding = 1e-6;  // periods
    if (tracks.empty() && at_periods_ < until - rounding) play_step({}, until - at_periods_);
    const auto dwell = static_cast<double>(dwell_);
    while (at_periods_ < until - rounding) {
        std::vector<Focus> foci;
        for (std::size_t i = 0; i < tracks.size(); ++i) {
            const double advance = dwell / (carrier_hz_ * tracks[i].seconds());
            const auto [leg, position] = tracks[i].at(std::fmod(shares_[i] + 0.5 * advance, 1.0));
            shares_[i] = std::fmod(shares_[i] + advance, 1.0);
            add(foci, *leg, position, tracks[i].am_hz, (at_periods_ + 0.5 * dwell) / carrier_hz_, played);
        }
        for (Focus& focus : foci) focus.amplitude *= amplitude;
        play_step(foci, dwell);
    }
    return played;
}

Played PathPen::play_pass(const std::vector<Voice>& voices, std::optional<std::size_t> points) {
    Played played;
    const std::vector<Track> tracks = tracks_of(voices);
    if (tracks.empty()) throw bad_argument("path", "there is nothing to draw");
    const double pass_s = tracks.front().seconds(), periods = pass_s * carrier_hz_;
    const double steps =
        points ? static_cast<double>(*points)
               : std::max(1.0, std::min(std::round(periods / static_cast<double>(dwell_)), std::floor(periods)));
    if (!(periods / steps >= 1.0 - 1e-9))
        throw impossible(
            points ? "points" : "speed",
            fmt::format("{} points in a pass of {:.1f} carrier periods leave {:.3g} to each, and a focus lasts "
                        "at least one; take fewer points, or a lower speed or frequency",
                        steps, periods, periods / steps),
            {"points", "speed", "frequency"});
    std::vector<bool> met;
    for (double i = 0.0; i < steps; ++i) {
        const double share = (i + 0.5) / steps;
        std::vector<Focus> foci;
        for (const Track& track : tracks) {
            const double passes = std::max(1.0, std::round(pass_s / track.seconds()));
            const double am_hz = track.am_hz > 0.0 ? std::max(1.0, std::round(track.am_hz * pass_s)) / pass_s : 0.0;
            const auto [leg, position] = track.at(std::fmod(share * passes, 1.0));
            add(foci, *leg, position, am_hz, share * pass_s, played);
            met.resize(std::max(met.size(), leg->line + 1), false);
            if (!leg->silent) met[leg->line] = true;
        }
        play_step(foci, periods / steps);
    }
    for (const Voice& voice : voices)
        for (const Leg& leg : voice.legs) met.resize(std::max(met.size(), leg.line + 1), false);
    played.lines_missed = static_cast<std::size_t>(std::count(met.begin(), met.end(), false));
    return played;
}

}  // namespace haptogram
