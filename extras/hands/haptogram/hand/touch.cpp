// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/touch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/hand/contour.hpp"

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

namespace {

constexpr std::array<AlgorithmName, 12> names{{
    {'A', "intersection", "where the surface cuts the skin"},
    {'B', "features", "edges and corners"},
    {'C', "deepest", "A, and a modulated focus at the deepest point"},
    {'D', "solid", "A, and a contour near the deepest point"},
    {'E', "random-grain", "random short lines inside"},
    {'F', "fixed-grain", "short lines that stay in space"},
    {'G', "blobs", "circles that grow with the depth"},
    {'H', "features-intersection", "B and A"},
    {'I', "features-solid", "B and D"},
    {'J', "features-blobs", "B and G"},
    {'K', "pointer", "a modulated focus that goes slowly along A"},
    {'L', "press", "foci that turn slowly on small circles"},
}};

void require(bool good, const char* setting, double value, const char* expected) {
    if (!good) throw bad_argument(setting, fmt::format("found {}, expected {}", value, expected));
}

void check(const TouchOptions& o) {
    const auto positive = [](const char* setting, double value) {
        require(value > 0.0 && std::isfinite(value), setting, value, "a positive number");
    };
    positive("corner_radius", o.feature.radius_m);
    positive("corner_line", o.feature.line_m);
    positive("corner_triangle", o.feature.triangle_m);
    positive("grain_spacing", o.grain.spacing_m);
    positive("grain_length", o.grain.length_m);
    positive("am_frequency", o.am_hz);
    positive("blob_finger", o.blob_finger_m);
    positive("blob_palm", o.blob_palm_m);
    positive("blob_palm_gain", o.blob_palm_gain);
    positive("pointer_speed", o.pointer_speed_m_s);
    positive("pointer_window", o.pointer_window_m);
    positive("press_hz", o.press.turns_hz);
    positive("press_radius", o.press.radius_m);
    require(o.feature.pulse_share >= 0.0 && o.feature.pulse_share < 1.0, "corner_pulse", o.feature.pulse_share,
            "a share from 0 to less than 1");
    require(o.feature.points >= 2, "corner_points", static_cast<double>(o.feature.points), "at least 2");
    require(o.grain.points >= 2, "grain_points", static_cast<double>(o.grain.points), "at least 2");
    require(o.solid_level > 0.0 && o.solid_level < 1.0, "solid_level", o.solid_level, "a share between 0 and 1");
    require(o.gap_m >= 0.0 && std::isfinite(o.gap_m), "gap", o.gap_m, "a distance, not negative");
    require(o.pointer_wait_s >= 0.0 && std::isfinite(o.pointer_wait_s), "wait", o.pointer_wait_s,
            "a time, not negative");
    require(o.press.foci >= 1, "press_foci", o.press.foci, "at least 1");
}

/// The skin in the object: depth maps that are made when they are first needed, and what is drawn from them.
class Meeting {
public:
    Meeting(const TouchObject& object, const std::vector<SkinRegion>& skin, double time_s, const TouchOptions& options,
            DepthFor use)
        : object_(object), skin_(skin), time_s_(time_s), options_(options) {
        for (const SkinRegion& region : skin) maps_.push_back(depth_map(region, object.solid, use));
    }

    [[nodiscard]] std::vector<SkinLine> intersection() const { return at_depth(0.0, LineKind::contour); }

    [[nodiscard]] std::vector<SkinLine> inner_contour() const {
        const auto deepest = deepest_of(skin_, maps_);
        if (!deepest) return {};
        return at_depth(options_.solid_level * deepest->depth, LineKind::solid);
    }

    [[nodiscard]] std::vector<SkinLine> features() const {
        return feature_lines(object_, skin_, time_s_, options_.feature);
    }

    [[nodiscard]] std::vector<SkinLine> grain(bool fixed) const {
        std::vector<SkinLine> lines;
        for (std::size_t i = 0; i < skin_.size(); ++i) {
            const auto some = fixed ? haptogram::fixed_grain(skin_[i], maps_[i], i, options_.grain)
                                    : haptogram::random_grain(skin_[i], maps_[i], time_s_, i, options_.grain);
            lines.insert(lines.end(), some.begin(), some.end());
        }
        return lines;
    }

    /// A circle around the middle of each fingertip's pad and of the palm, when some of it is inside.
    [[nodiscard]] std::vector<SkinLine> blobs() const {
        std::vector<SkinLine> lines;
        for (std::size_t i = 0; i < skin_.size(); ++i) {
            const SkinRegion& region = skin_[i];
            const SkinPatch& patch = region.patches.back();
            const std::size_t first = region.patches.size() > 1 ? region.patches[region.patches.size() - 2].end_row : 0;
            const auto begin = maps_[i].depth.begin() + static_cast<std::ptrdiff_t>(first * region.columns);
            const double depth = *std::max_element(begin, maps_[i].depth.end());
            if (!(depth > 0.0)) continue;
            const bool palm = patch.radius == 0.0;
            const double radius = palm ? std::min(options_.blob_palm_gain * depth, options_.blob_palm_m)
                                       : std::min(depth, options_.blob_finger_m);
            const SkinPoint middle{patch.from + 0.5 * patch.length * patch.along + patch.radius * patch.out, patch.out};
            lines.push_back(skin_circle(middle, radius, LineKind::blob, i));
        }
        return lines;
    }

    /// Features, and what is left of the other lines beside them.
    [[nodiscard]] std::vector<SkinLine> with_features(std::vector<SkinLine> others) const {
        std::vector<SkinLine> lines = features();
        if (options_.priority == Priority::gap) {
            others = away_from(others, points_along(lines, options_.feature.step_m), options_.gap_m);
        } else {
            std::erase_if(others, [&](const SkinLine& line) {
                return std::any_of(lines.begin(), lines.end(),
                                   [&](const SkinLine& feature) { return feature.region == line.region; });
            });
        }
        lines.insert(lines.end(), others.begin(), others.end());
        return lines;
    }

    /// For each region that is touched, lines of one focus each, evenly around the deepest point.
    [[nodiscard]] std::vector<SkinLine> presses() const {
        std::vector<SkinLine> lines;
        for (std::size_t i = 0; i < skin_.size(); ++i) {
            if (!maps_[i].touched) continue;
            const std::size_t at = maps_[i].deepest;
            SkinLine circle =
                skin_circle({skin_[i].points[at], skin_[i].normals[at]}, options_.press.radius_m, LineKind::press, i);
            for (SkinPoint& point : circle.points) point = skin_[i].nearest(point.position);
            for (unsigned k = 0; k < options_.press.foci; ++k) {
                SkinLine one = circle;
                std::rotate(
                    one.points.begin(),
                    one.points.begin() + static_cast<std::ptrdiff_t>(k * circle.points.size() / options_.press.foci),
                    one.points.end());
                lines.push_back(std::move(one));
            }
        }
        return lines;
    }

    [[nodiscard]] std::optional<Deepest> deepest() const { return deepest_of(skin_, maps_); }

private:
    [[nodiscard]] std::vector<SkinLine> at_depth(double level, LineKind kind) const {
        std::vector<SkinLine> lines;
        for (std::size_t i = 0; i < skin_.size(); ++i) {
            auto some = contours(skin_[i], maps_[i], level, i, kind);
            lines.insert(lines.end(), std::make_move_iterator(some.begin()), std::make_move_iterator(some.end()));
        }
        return lines;
    }

    const TouchObject& object_;
    const std::vector<SkinRegion>& skin_;
    double time_s_;
    const TouchOptions& options_;
    std::vector<DepthMap> maps_;
};

/// The direction of a line between two arc lengths; it goes round when the line is closed.
class Arc {
public:
    explicit Arc(const SkinLine& line) : points_(opened(line)), closed_(line.closed) {
        until_.push_back(0.0);
        for (std::size_t i = 1; i < points_.size(); ++i)
            until_.push_back(until_.back() + distance(points_[i - 1].position, points_[i].position));
    }
    [[nodiscard]] double until(std::size_t i) const { return until_[i]; }
    [[nodiscard]] double length() const { return until_.back(); }
    /// By how much the line turns around an arc length, radians.
    [[nodiscard]] double turn(double s, double window) const {
        const Vec3 before = at(s) - at(s - 0.5 * window), after = at(s + 0.5 * window) - at(s);
        return std::atan2(norm(cross(before, after)), dot(before, after));
    }

private:
    [[nodiscard]] Vec3 at(double s) const {
        if (closed_) s -= length() * std::floor(s / length());
        s = std::clamp(s, 0.0, length());  // beyond an open end there is no line, and so no turn
        const auto after = std::upper_bound(until_.begin() + 1, until_.end() - 1, s);
        const auto i = static_cast<std::size_t>(after - until_.begin());
        const double part = until_[i] - until_[i - 1];
        return between(points_[i - 1], points_[i], part > 0.0 ? (s - until_[i - 1]) / part : 0.0).position;
    }
    std::vector<SkinPoint> points_;
    std::vector<double> until_;
    bool closed_;
};

/// Points of a line at which it turns most within the window, and by more than the angle.
std::vector<bool> corners_of(const SkinLine& line, double window, double least_rad) {
    const Arc arc(line);
    const std::size_t count = line.points.size();
    std::vector<double> turns;
    for (std::size_t i = 0; i < count; ++i) turns.push_back(arc.turn(arc.until(i), window));
    std::vector<bool> corners(count, false);
    for (std::size_t i = 0; i < count; ++i) {
        if (turns[i] < least_rad) continue;
        bool most = true;  // of its surroundings; of equal ones the first
        for (std::size_t k = 0; k < count && most; ++k) {
            double apart = std::abs(arc.until(i) - arc.until(k));
            if (line.closed) apart = std::min(apart, arc.length() - apart);
            most = k == i || apart > window || turns[k] < turns[i] || (turns[k] == turns[i] && i < k);
        }
        corners[i] = most;
    }
    return corners;
}

Voice pointer_voice(const std::vector<SkinLine>& lines, const Pace& pace, Jump jump, const TouchOptions& options) {
    Voice voice = drawn(lines, pace, jump);
    Voice waiting;
    std::vector<std::vector<Vec3>> stops;
    for (const SkinLine& line : lines) {
        const std::vector<bool> corners =
            corners_of(line, options.pointer_window_m, options.pointer_turn_deg * std::numbers::pi / 180.0);
        std::vector<Vec3>& some = stops.emplace_back();
        for (std::size_t i = 0; i < corners.size(); ++i)
            if (corners[i]) some.push_back(line.points[i].position);
    }
    for (const Leg& leg : voice.legs) {
        const std::vector<Vec3>& here = stops[leg.line];
        const bool stop = !leg.silent && std::find(here.begin(), here.end(), leg.from.position) != here.end();
        if (stop && options.pointer_wait_s > 0.0)
            waiting.legs.push_back({leg.from, leg.from, options.pointer_wait_s, false, leg.line});
        waiting.legs.push_back(leg);
    }
    return waiting;
}

}  // namespace

std::span<const AlgorithmName> algorithm_names() { return names; }

const AlgorithmName& name_of(Algorithm algorithm) { return names.at(static_cast<std::size_t>(algorithm)); }

Algorithm algorithm_of(const std::string& name) {
    for (std::size_t i = 0; i < names.size(); ++i) {
        const bool letter = name.size() == 1 && std::toupper(static_cast<unsigned char>(name[0])) == names.at(i).letter;
        if (letter || name == names.at(i).name) return static_cast<Algorithm>(i);
    }
    std::string known;
    for (const AlgorithmName& one : names)
        known += fmt::format("{}{} ({})", known.empty() ? "" : ", ", one.letter, one.name);
    throw bad_argument("algorithm", fmt::format("found \"{}\", expected {}", name.substr(0, 40), known));
}

std::uint32_t usual_dwell(Algorithm algorithm) {
    return algorithm == Algorithm::pointer || algorithm == Algorithm::press ? 400 : 10;
}

Touch touch_of(Algorithm algorithm, const TouchObject& object, const std::vector<SkinRegion>& skin, double time_s,
               const TouchOptions& options) {
    check(options);
    const bool only_contours = algorithm == Algorithm::intersection || algorithm == Algorithm::features_intersection ||
                               algorithm == Algorithm::pointer || algorithm == Algorithm::random_grain ||
                               algorithm == Algorithm::fixed_grain;
    Pace pace = options.pace.value_or(Pace{usual_speed_m_s, {}});
    Touch made;
    const auto draw = [&](const std::vector<SkinLine>& lines) {
        Voice voice = drawn(lines, pace, options.jump);
        const std::size_t first = made.lines.size();
        for (Leg& leg : voice.legs) leg.line += first;
        if (!voice.legs.empty()) made.voices.push_back(std::move(voice));
        made.lines.insert(made.lines.end(), lines.begin(), lines.end());
    };
    const auto both = [](std::vector<SkinLine> a, const std::vector<SkinLine>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    };
    if (algorithm == Algorithm::features) {  // needs no depths
        draw(toured(feature_lines(object, skin, time_s, options.feature)));
        return made;
    }
    const Meeting meeting(object, skin, time_s, options, only_contours ? DepthFor::contour : DepthFor::inside);
    switch (algorithm) {
        case Algorithm::features: break;
        case Algorithm::intersection: draw(toured(meeting.intersection())); break;
        case Algorithm::deepest:
            draw(toured(meeting.intersection()));
            if (const auto deepest = meeting.deepest()) {
                const SkinPoint& at = deepest->at;
                made.voices.push_back({{{at, at, 1.0 / options.am_hz, false, made.lines.size()}}, options.am_hz});
                made.lines.push_back({{at}, false, LineKind::pointer, deepest->region});
            }
            break;
        case Algorithm::solid:
            if (options.two_foci) {
                draw(toured(meeting.intersection()));
                draw(toured(meeting.inner_contour()));
            } else {
                draw(toured(both(meeting.intersection(), meeting.inner_contour())));
            }
            break;
        case Algorithm::random_grain: draw(meeting.grain(false)); break;
        case Algorithm::fixed_grain: draw(meeting.grain(true)); break;
        case Algorithm::blobs: draw(toured(meeting.blobs())); break;
        case Algorithm::features_intersection: draw(toured(meeting.with_features(meeting.intersection()))); break;
        case Algorithm::features_solid:
            draw(toured(meeting.with_features(both(meeting.intersection(), meeting.inner_contour()))));
            break;
        case Algorithm::features_blobs: draw(toured(meeting.with_features(meeting.blobs()))); break;
        case Algorithm::pointer: {
            std::vector<SkinLine> lines = toured(meeting.intersection());
            for (SkinLine& line : lines) line.kind = LineKind::pointer;
            pace = options.pace.value_or(Pace{options.pointer_speed_m_s, {}});
            Voice voice = pointer_voice(lines, pace, options.jump, options);
            if (!voice.legs.empty()) made.voices.push_back(std::move(voice));
            made.lines = std::move(lines);
            made.am_hz = options.am_hz;
            break;
        }
        case Algorithm::press:
            pace = options.pace.value_or(Pace{{}, options.press.turns_hz});
            for (const SkinLine& line : meeting.presses()) draw({line});
            break;
    }
    return made;
}

}  // namespace haptogram
