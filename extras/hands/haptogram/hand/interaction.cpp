// SPDX-License-Identifier: Apache-2.0
#include "haptogram/hand/interaction.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/render.hpp"
#include "haptogram/shape/path_file.hpp"
#include "haptogram/shape/place.hpp"
#include "haptogram/verbs/compile.hpp"

namespace haptogram {
namespace {

using std::numbers::pi;
constexpr double gravity_m_s2 = 9.80665;
constexpr double lost_below_palm_m = 0.05;  // a ball that is so far below the palm has missed it
constexpr double drop_fall_s = 0.25;        // for which a drop is drawn before it hits
constexpr double drop_m_s = 0.6;            // at which it is drawn falling
constexpr double new_turn_s = 0.3;          // after which the creature turns otherwise
constexpr double most_turn_rate = pi;       // rad/s

Vec3 flat(Vec3 p) { return {p.x, p.y, 0.0}; }

}  // namespace

Content content_of(std::string_view name) {
    if (name == "ball") return Content::ball;
    if (name == "rain") return Content::rain;
    if (name == "creature") return Content::creature;
    throw bad_argument("content", fmt::format("found \"{}\", expected ball, rain or creature", name));
}

Interaction::Interaction(Content content, const InteractionOptions& options)
    : content_(content),
      options_(options),
      random_{static_cast<std::int64_t>(options.seed), static_cast<std::int64_t>(content)} {
    for (const auto& [setting, value] :
         {std::pair("palm_radius", options.palm_radius_m), std::pair("ball_height", options.ball_height_m),
          std::pair("ball_contact", options.ball_contact_s), std::pair("rain", options.rain_hz),
          std::pair("drop", options.drop_s), std::pair("creature", options.creature_m_s)})
        require_positive(setting, value);
}

std::optional<Vec3> Interaction::advance(double seconds, Vec3 palm) {
    if (!begun_) {
        last_palm_ = palm;
        if (content_ == Content::ball) fall_anew(palm);
        begun_ = true;
    }
    const std::optional<Vec3> touch = content_ == Content::ball   ? bounce(seconds, palm)
                                      : content_ == Content::rain ? rain(seconds, palm)
                                                                  : walk(seconds, palm);
    last_palm_ = palm;
    return touch;
}

void Interaction::fall_anew(Vec3 palm) {
    place_ = palm + Vec3{0.0, 0.0, options_.ball_height_m};
    velocity_ = {};
    touching_ = false;
}

/// The ball is a mass on a spring while it touches: half an oscillation takes the time of the contact, and gives all
/// energy back.
std::optional<Vec3> Interaction::bounce(double seconds, Vec3 palm) {
    const double stiffness = pi * pi / (options_.ball_contact_s * options_.ball_contact_s);  // over the mass, 1/s²
    constexpr int parts = 20;
    const double h = seconds / parts;
    const auto above = [&](Vec3 at) { return norm(flat(place_ - at)) <= options_.palm_radius_m; };
    const auto acceleration = [&](Vec3 at) {
        const double depth = at.z - place_.z;
        return -gravity_m_s2 + (depth > 0.0 && above(at) ? stiffness * depth : 0.0);
    };
    for (int i = 0; i < parts; ++i) {  // leapfrog
        const Vec3 here = last_palm_ + (static_cast<double>(i) / parts) * (palm - last_palm_);
        const Vec3 next = last_palm_ + (static_cast<double>(i + 1) / parts) * (palm - last_palm_);
        velocity_.z += 0.5 * h * acceleration(here);
        place_ = place_ + h * velocity_;
        velocity_.z += 0.5 * h * acceleration(next);
    }
    if (place_.z < palm.z - lost_below_palm_m) fall_anew(palm);
    things_ = {place_};
    const bool touches = place_.z < palm.z && above(palm);
    if (touches && !touching_) ++touches_;
    touching_ = touches;
    if (!touches) return std::nullopt;
    return Vec3{place_.x, place_.y, palm.z};
}

Vec3 Interaction::random_place() {
    const double radius = options_.palm_radius_m * std::sqrt(random_.uniform(0.0, 1.0));
    const double angle = random_.uniform(0.0, 2.0 * pi);
    return {radius * std::cos(angle), radius * std::sin(angle), 0.0};
}

/// A Poisson process: the times between drops are exponential. The newest drop is the one that is felt.
std::optional<Vec3> Interaction::rain(double seconds, Vec3 palm) {
    const auto wait = [&] { return -std::log(1.0 - random_.uniform(0.0, 1.0)) / options_.rain_hz; };
    if (next_s_ == 0.0) next_s_ = wait();
    felt_s_ -= seconds;
    next_s_ -= seconds;
    while (next_s_ <= 0.0) {
        drops_.push_back({random_place(), drop_fall_s + next_s_});
        next_s_ += wait();
    }
    things_.clear();
    for (Drop& drop : drops_) {
        drop.until_s -= seconds;
        if (drop.until_s <= 0.0) {
            hit_ = drop.place;
            felt_s_ = options_.drop_s;
            ++touches_;
        } else {
            things_.push_back(palm + drop.place + Vec3{0.0, 0.0, drop_m_s * drop.until_s});
        }
    }
    std::erase_if(drops_, [](const Drop& drop) { return drop.until_s <= 0.0; });
    if (felt_s_ <= 0.0) return std::nullopt;
    return palm + hit_;
}

/// It keeps its speed on the palm, turns at a rate that changes now and then, and turns back at the rim.
std::optional<Vec3> Interaction::walk(double seconds, Vec3 palm) {
    next_s_ -= seconds;
    if (touches_ == 0) {
        heading_ = random_.uniform(0.0, 2.0 * pi);
        touches_ = 1;
    }
    if (next_s_ <= 0.0) {
        turn_rate_ = random_.uniform(-most_turn_rate, most_turn_rate);
        next_s_ += new_turn_s;
    }
    heading_ += turn_rate_ * seconds;
    const auto step = [&] {
        return options_.creature_m_s * seconds * Vec3{std::cos(heading_), std::sin(heading_), 0.0};
    };
    if (norm(place_ + step()) > options_.palm_radius_m) heading_ = std::atan2(-place_.y, -place_.x);
    place_ = place_ + step();
    things_ = {palm + place_};
    return palm + place_;
}

PlayedInteraction interact(Content content, std::span<const MarkerSample> marker, const InteractionOptions& options,
                           double carrier_hz) {
    if (marker.size() < 2)
        throw bad_input("marker",
                        fmt::format("{} samples of the marker; an interaction needs at least two", marker.size()));
    for (std::size_t i = 0; i < marker.size(); ++i)
        if (!is_finite(marker[i].position) || !std::isfinite(marker[i].time_s) ||
            (i > 0 && !(marker[i].time_s > marker[i - 1].time_s)))
            throw bad_input("marker",
                            fmt::format("sample {}: its place must be finite, and its time later than the one "
                                        "before it",
                                        i + 1));
    Interaction content_now(content, options);
    PlayedInteraction played;
    played.path.modulation = options.modulation;
    const auto periods = static_cast<std::uint32_t>(std::max<std::int64_t>(1, std::llround(1e-3 * carrier_hz)));
    const double step_s = periods / carrier_hz;
    const double length_s = marker.back().time_s - marker.front().time_s;
    const auto steps = static_cast<std::size_t>(std::max(1.0, std::floor(length_s / step_s + 1e-9)));
    std::size_t sample = 0;
    std::optional<Vec3> last;  // where the focus is
    for (std::size_t i = 0; i < steps; ++i) {
        const double time_s = static_cast<double>(i) * step_s;
        const double at = marker.front().time_s + time_s;
        while (sample + 2 < marker.size() && marker[sample + 1].time_s <= at) ++sample;
        const MarkerSample &before = marker[sample], &after = marker[sample + 1];
        std::optional<Vec3> focus, palm;
        if (after.time_s - before.time_s > options.longest_gap_s) {
            played.lost_s += step_s;
        } else {
            const double share = (at - before.time_s) / (after.time_s - before.time_s);
            palm = before.position + share * (after.position - before.position) + options.palm_from_marker;
            focus = content_now.advance(step_s, *palm);
        }
        if (focus) {
            const Vec3 asked = *focus;
            if (options.grid) focus = options.grid->nearest(asked);
            const bool outside = asked.z < options.lowest_m || asked.z > options.highest_m ||
                                 (options.grid && (std::abs(asked.x - focus->x) > 0.5 * options.grid->pitch_m + 1e-9 ||
                                                   std::abs(asked.y - focus->y) > 0.5 * options.grid->pitch_m + 1e-9));
            if (outside) {
                played.out_of_range_s += step_s;
                focus.reset();
            } else {
                if (!options.grid && last && distance(*last, *focus) <= options.spacing_m) focus = last;
                played.felt_s += step_s;
            }
        }
        std::vector<Focus> foci;
        if (focus) foci.push_back({*focus});
        if (!played.path.steps.empty() && played.path.steps.back().foci == foci)
            played.path.steps.back().periods += periods;
        else
            played.path.steps.push_back({std::move(foci), periods});
        last = focus;
        if (i % 10 == 0) played.scene.push_back({time_s, palm, content_now.things(), focus});
    }
    played.touches = content_now.touches();
    return played;
}

using nlohmann::ordered_json;

MarkerTrack open_marker(const std::string& name, double noise_px, std::uint64_t seed, double carrier_hz) {
    if (name.ends_with(".csv")) {
        MarkerTrack track;
        std::uint64_t periods = 0;
        for (const PathStep& step : path_from_csv(read_file(name), name, carrier_hz).steps) {
            if (step.foci.empty())
                ++track.unseen;
            else
                track.samples.push_back({static_cast<double>(periods) / carrier_hz, step.foci.front().position});
            periods += step.periods;
        }
        return track;
    }
    MarkerTracker tracker = usual_tracker();
    tracker.noise_px = noise_px;
    tracker.seed = seed;
    return track_marker(open_hands(name), tracker);
}

InteractionOnArray interact(const InteractionRequest& request) {
    Project project;
    project.array = request.array;
    project.board = request.board;
    const ProjectInstrument instrument = instrument_of(project);
    InteractionOnArray made;
    made.array = instrument.array;
    made.carrier_hz = choose_timer(instrument.array, instrument.core).carrier_hz();
    InteractionOptions options = request.options;
    if (request.grid) options.grid = interaction_grid();
    options.modulation = modulation_of(request.am, request.am_law, made.carrier_hz).modulation;
    made.track = open_marker(request.hand, request.noise_px, options.seed, made.carrier_hz);
    made.played = interact(content_of(request.content), made.track.samples, options, made.carrier_hz);
    if (!(made.played.felt_s > 0.0))
        throw bad_input(request.hand, fmt::format("nothing touches the palm where the device reaches ({:.3g} s are out "
                                                  "of its reach); move the hand to heights of {:g} to {:g} mm",
                                                  made.played.out_of_range_s, options.lowest_m / millimetre,
                                                  options.highest_m / millimetre));
    require_reachable(made.played.path, made.array);
    if (made.played.out_of_range_s > 0.0)
        made.warnings.push_back(fmt::format("for {:.3g} s the focus would be out of the device's reach, and is silent",
                                            made.played.out_of_range_s));
    if (made.track.unseen > 0)
        made.warnings.push_back(fmt::format("a camera does not see the marker in {} of {} pictures", made.track.unseen,
                                            made.track.unseen + made.track.samples.size()));
    return made;
}

std::string to_json_lines(const std::vector<SceneMoment>& scene) {
    const auto in_mm = [](Vec3 p) { return ordered_json{p.x / millimetre, p.y / millimetre, p.z / millimetre}; };
    std::string text;
    for (const SceneMoment& moment : scene) {
        ordered_json line = {{"time_s", moment.time_s}, {"things_mm", ordered_json::array()}};
        if (moment.palm) line["palm_mm"] = in_mm(*moment.palm);
        for (const Vec3& thing : moment.things) line["things_mm"].push_back(in_mm(thing));
        if (moment.focus) line["focus_mm"] = in_mm(*moment.focus);
        text += line.dump() + "\n";
    }
    return text;
}

}  // namespace haptogram
