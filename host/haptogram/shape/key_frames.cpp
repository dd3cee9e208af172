// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/key_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "haptogram/array/pose.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

double eased(Ease ease, double part) {
    if (ease == Ease::step) return 0.0;
    return ease == Ease::linear ? part : part * part * (3.0 - 2.0 * part);
}

template <class Value>
Value mixed(const Value& from, const Value& to, double part) {
    return from + part * (to - from);
}

/// What holds between two key frames, but for the form.
KeyFrame between(const KeyFrame& from, const KeyFrame& to, double part) {
    const auto mix = [part](const auto& a, const auto& b) { return mixed(a, b, part); };
    return {.time_s = mix(from.time_s, to.time_s),
            .move = mix(from.move, to.move),
            .turn_deg = mix(from.turn_deg, to.turn_deg),
            .scale = mix(from.scale, to.scale),
            .amplitude = mix(from.amplitude, to.amplitude),
            .am_hz = mix(from.am_hz, to.am_hz)};
}

/// Key frames' times in whole carrier periods.
std::vector<std::uint64_t> times_of(const std::vector<KeyFrame>& frames, double carrier_hz, const Forms& forms) {
    constexpr double longest_s = 1e6;
    std::vector<std::uint64_t> times;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const KeyFrame& frame = frames[i];
        const auto require = [&](bool good, const char* what, double found, const char* expected) {
            if (!good)
                throw bad_argument("keyframe",
                                   fmt::format("key frame {}: found {} {}, expected {}", i + 1, what, found, expected));
        };
        require(frame.time_s >= 0.0 && frame.time_s <= longest_s, "the time", frame.time_s, "0 to 1000000 s");
        require(i > 0 || frame.time_s == 0.0, "the time", frame.time_s, "0 s, as it is the first");
        require(is_finite(frame.move), "a movement that is not finite,", norm(frame.move), "millimetres");
        require(is_finite(frame.turn_deg), "an angle that is not finite,", norm(frame.turn_deg), "degrees");
        require(frame.scale > 0.0 && frame.scale <= 1e9, "the scale", frame.scale, "above 0");
        require(frame.amplitude >= 0.0 && frame.amplitude <= 1.0, "the amplitude", frame.amplitude, "0 to 1");
        require(frame.am_hz >= 0.0 && frame.am_hz <= carrier_hz / 2.0, "am_hz", frame.am_hz,
                "0 to half of the carrier's frequency");
        if (frame.shape != 0 && !forms.contains(frame.shape))
            throw bad_argument("keyframe",
                               fmt::format("key frame {}: found the shape {}, which is not there", i + 1, frame.shape));
        times.push_back(static_cast<std::uint64_t>(std::llround(frame.time_s * carrier_hz)));
        require(i == 0 || times[i] > times[i - 1], "the time", frame.time_s,
                "a later one than that of the frame before, by at least a carrier period");
    }
    return times;
}

/// The sum of squared ways from points of a pass to those of a tour. @param every  of the pass's points is looked at
double squares(const std::vector<Vec3>& pass, const std::vector<Vec3>& tour, std::size_t first, bool backwards,
               std::size_t every) {
    double sum = 0.0;
    for (std::size_t i = 0; i < pass.size(); i += every) {
        const std::size_t along = i * tour.size() / pass.size();
        const Vec3 way = tour[(first + (backwards ? tour.size() - along : along)) % tour.size()] - pass[i];
        sum += dot(way, way);
    }
    return sum;
}

/// How many foci a path has before each of its steps.
std::vector<std::size_t> foci_before(const Path& path) {
    std::vector<std::size_t> before{0};
    for (const PathStep& step : path.steps) before.push_back(before.back() + step.foci.size());
    return before;
}

}  // namespace

std::vector<Vec3> matched(const std::vector<Vec3>& pass, const std::vector<Vec3>& tour) {
    constexpr std::size_t most = 1024;
    const std::size_t every = (pass.size() + most - 1) / most;
    double least = std::numeric_limits<double>::infinity();
    std::size_t best = 0;
    bool best_backwards = false;
    for (const bool backwards : {false, true})
        for (std::size_t first = 0; first < tour.size(); ++first)
            if (const double sum = squares(pass, tour, first, backwards, every); sum < least) {
                least = sum;
                best = first;
                best_backwards = backwards;
            }
    std::vector<Vec3> becomes;
    becomes.reserve(pass.size());
    for (std::size_t i = 0; i < pass.size(); ++i) {
        const std::size_t along = i * tour.size() / pass.size();
        becomes.push_back(tour[(best + (best_backwards ? tour.size() - along : along)) % tour.size()]);
    }
    return becomes;
}

Path moved_by(const std::vector<KeyFrame>& frames, const Path& pass, Vec3 centre, double carrier_hz,
              std::size_t most_steps, const Forms& forms) {
    if (frames.size() < 2)
        throw bad_argument(
            "keyframe",
            fmt::format("found {}, expected at least two key frames: one at 0 s, and one where the path ends",
                        frames.size()));
    const std::vector<std::uint64_t> times = times_of(frames, carrier_hz, forms);
    const std::vector<std::size_t> before = foci_before(pass);
    Path path;
    path.modulation = pass.modulation;
    double beats = 0.0;  // of the amplitude's rise and fall
    std::size_t key = 0;
    std::uint64_t now = 0;
    for (std::size_t i = 0; now < times.back(); i = (i + 1) % pass.steps.size()) {
        for (const std::uint64_t end = std::min(now + pass.steps[i].periods, times.back()); now < end;) {
            if (now == times[key + 1]) ++key;
            const std::uint64_t until = std::min(end, times[key + 1]);
            if (path.steps.size() == most_steps)
                throw bad_input("keyframe",
                                fmt::format("the path has more than {} steps, which is what the board can play; take "
                                            "fewer points, fewer passes a second, or a shorter time",
                                            most_steps),
                                {"points", "rate"});
            const double middle_s = 0.5 * static_cast<double>(now + until) / carrier_hz;
            const KeyFrame &from = frames[key], &to = frames[key + 1];
            const double part = eased(from.ease, (middle_s - from.time_s) / (to.time_s - from.time_s));
            const KeyFrame at = between(from, to, part);
            const double lasts_s = static_cast<double>(until - now) / carrier_hz;
            const double factor =
                at.am_hz == 0.0 ? 1.0
                                : 0.5 + 0.5 * std::cos(2.0 * std::numbers::pi * (beats + 0.5 * at.am_hz * lasts_s));
            beats = at.am_hz == 0.0 ? 0.0 : std::fmod(beats + at.am_hz * lasts_s, 1.0);
            const Pose pose = pose_of(centre + at.move, at.turn_deg);
            PathStep step{.foci = {}, .periods = static_cast<std::uint32_t>(until - now)};
            step.mark = now == times[key] && frames[key].mark;
            for (std::size_t k = 0; k < pass.steps[i].foci.size(); ++k) {
                const Focus& focus = pass.steps[i].foci[k];
                const auto place = [&](const KeyFrame& frame) {
                    return frame.shape == 0 ? focus.position : forms.at(frame.shape)[before[i] + k];
                };
                if (const double amplitude = focus.amplitude * at.amplitude * factor; amplitude > 0.0)
                    step.foci.push_back(
                        {pose.outwards(at.scale * (mixed(place(from), place(to), part) - centre)), amplitude});
            }
            path.steps.push_back(std::move(step));
            now = until;
        }
    }
    return path;
}

}  // namespace haptogram
