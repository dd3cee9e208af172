// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/hand_feeler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/touch.hpp"
#include "haptogram/verbs/focus_analysis.hpp"

namespace haptogram::live {

Prediction prediction_of(std::string_view name) {
    if (name == "none") return Prediction::none;
    if (name == "velocity") return Prediction::velocity;
    if (name == "kalman") return Prediction::kalman;
    throw bad_argument("predict", fmt::format("found \"{}\", expected none, velocity or kalman", name));
}

Predictor::Predictor(const PredictorOptions& options) : options_(options) {
    if (!(options.ahead_s >= 0.0 && options.ahead_s < 1.0))
        throw bad_argument("latency", fmt::format("found {} s, expected 0 to 1 s", options.ahead_s));
    if (!(options.place_noise_m > 0.0 && options.acceleration_m_s2 > 0.0))
        throw bad_argument("prediction", "its noise must be positive");
}

void Predictor::filter(Track& track, Vec3 place, double seconds) const {
    const double t = seconds, q = options_.acceleration_m_s2 * options_.acceleration_m_s2;
    auto& [pp, pv, vv] = track.variance;
    pp += 2.0 * t * pv + t * t * vv + 0.25 * t * t * t * t * q;
    pv += t * vv + 0.5 * t * t * t * q;
    vv += t * t * q;
    const Vec3 expected = track.place + t * track.velocity;
    const double total = pp + options_.place_noise_m * options_.place_noise_m;
    const double gain_p = pp / total, gain_v = pv / total;
    track.place = expected + gain_p * (place - expected);
    track.velocity = track.velocity + gain_v * (place - expected);
    vv -= gain_v * pv;
    pv -= gain_v * pp;
    pp -= gain_p * pp;
}

Vec3 Predictor::ahead(std::uint64_t finger, Vec3 place, double measured_s, double now_s) {
    if (options_.kind == Prediction::none) return place;
    const auto [found, fresh] = tracks_.try_emplace(finger);
    Track& track = found->second;
    const double seconds = measured_s - track.time_s;
    if (fresh || seconds < 0.0) {
        constexpr double unknown_m_s = 1.0;
        track = {};
        track.place = place;
        track.variance = {options_.place_noise_m * options_.place_noise_m, 0.0, unknown_m_s * unknown_m_s};
    } else if (seconds > 0.0 && options_.kind == Prediction::velocity) {
        track.velocity = (place - track.place) * (1.0 / seconds);
        track.place = place;
    } else if (seconds > 0.0) {
        filter(track, place, seconds);
        track.most_m_s = (distance(place, track.measured) + 2.0 * options_.place_noise_m) / seconds;
    }
    track.measured = place;
    track.time_s = measured_s;
    const double speed = norm(track.velocity), part = speed > track.most_m_s ? track.most_m_s / speed : 1.0;
    return track.place + (part * (options_.ahead_s + now_s - measured_s)) * track.velocity;
}

void Predictor::forget_before(double time_s) {
    std::erase_if(tracks_, [time_s](const auto& track) { return track.second.time_s < time_s; });
}

namespace {

constexpr double forget_s = 0.1;     ///< a hand that was not seen for so long is a new one
constexpr std::uint32_t dwell = 10;  ///< carrier periods between two foci of a pass

/// Whether sound from the middle of the array, or of one of a rig's, comes upon the skin from outside.
bool faces(const Array& array, const SkinPoint& at) {
    if (array.faces.empty()) return dot(at.position, at.normal) < 0.0;
    return std::any_of(array.faces.begin(), array.faces.end(),
                       [&](const Pose& face) { return dot(at.position - face.origin, at.normal) < 0.0; });
}

/// Leaves out what the sound cannot press on, and holds what is too short for a step as long as one.
/// @return whether anything was left out
bool keep_felt(const Array& array, std::vector<Voice>& voices, double step_s) {
    bool hidden = false;
    for (Voice& voice : voices) {
        hidden = std::erase_if(voice.legs,
                               [&](const Leg& leg) {
                                   return !leg.silent && !faces(array, leg.from) && !faces(array, leg.to);
                               }) > 0 ||
                 hidden;
        const double seconds = voice.seconds();
        if (seconds > 0.0 && seconds < step_s)
            for (Leg& leg : voice.legs) leg.seconds *= step_s / seconds;
    }
    std::erase_if(voices, [](const Voice& voice) {
        return std::all_of(voice.legs.begin(), voice.legs.end(), [](const Leg& leg) { return leg.silent; });
    });
    return hidden;
}

/// Places all over the surface of an object that can be seen from outside.
std::vector<Vec3> surface_places(const TouchObject& object) {
    constexpr int count = 200;
    constexpr double on_it_m = 1e-5;
    const Vec3 middle = 0.5 * (object.low + object.high);
    const double far = distance(object.low, object.high);
    std::vector<Vec3> places;
    for (int k = 0; k < count; ++k) {  // in directions that are spread evenly over a sphere
        const double z = 1.0 - (2.0 * k + 1.0) / count, turn = k * std::numbers::pi * (3.0 - std::sqrt(5.0));
        const double around = std::sqrt(1.0 - z * z);
        const Vec3 way{around * std::cos(turn), around * std::sin(turn), z};
        for (double at = far; at > -far;) {
            const double away = object.solid.distance(middle + at * way);
            if (at == far && away <= 0.0) break;  // a half-space goes on outside of its box
            if (away < on_it_m) {
                places.push_back(middle + at * way);
                break;
            }
            at -= away;
        }
    }
    return places;
}

/// What an array can do on an object's surface.
std::string reach_of(const Array& array, const FeltObject& told, const TouchObject& object) {
    std::size_t reached = 0;
    double least = HUGE_VAL, most = 0.0;
    std::string why;
    const std::vector<Vec3> places = surface_places(object);
    for (const Vec3 place : places) {
        const std::string beyond = array.unreachable(place);
        if (!beyond.empty()) {
            if (why.empty()) why = beyond;
            continue;
        }
        ++reached;
        const double pressure = reachable_pressure(array, place);
        least = std::min(least, pressure);
        most = std::max(most, pressure);
    }
    const std::string what =
        fmt::format("{} ({}) at ({:.0f}, {:.0f}, {:.0f}) mm", told.name, told.kind, told.pose.origin.x / millimetre,
                    told.pose.origin.y / millimetre, told.pose.origin.z / millimetre);
    if (reached == 0)
        return fmt::format("{}: nothing of it can be felt, the array does not reach it, {}", what,
                           why.empty() ? "for it has no surface" : why);
    return fmt::format("{}: the array reaches {:.0f} % of its surface, with {:.0f} to {:.0f} Pa of one focus{}", what,
                       100.0 * static_cast<double>(reached) / static_cast<double>(places.size()), least, most,
                       why.empty() ? why : fmt::format("; other places are silent, the first {}", why));
}

}  // namespace

std::size_t most_foci(const HandOptions& options) {
    if (options.algorithm == Algorithm::press) return 2 * std::size_t{options.touch.press.foci};
    const bool two =
        options.algorithm == Algorithm::deepest || (options.algorithm == Algorithm::solid && options.touch.two_foci);
    return two ? 2 : 1;
}

bool is_slow(const HandOptions& options) { return options.algorithm == Algorithm::pointer; }

HandFeeler::HandFeeler(const Array& array, double carrier_hz, Objects objects, const HandOptions& options)
    : array_(array),
      carrier_hz_(carrier_hz),
      objects_(std::move(objects)),
      options_(options),
      predictor_(options.predict) {
    static_cast<void>(touch_of(options.algorithm, {}, {}, 0.0, options.touch));  // refuses what makes no sense
    about_ = fmt::format("{}", fmt::join(news_of(*objects_(0.0)), "\n"));
}

/// What the array can do on objects that were not there before.
std::vector<std::string> HandFeeler::news_of(const ObjectsNow& objects) {
    std::vector<std::string> news;
    std::map<std::string, FeltObject> now;
    for (std::size_t i = 0; i < objects.told.size(); ++i) {
        const FeltObject& told = objects.told.at(i);
        const auto before = known_.find(told.name);
        if (before == known_.end() || before->second.kind != told.kind || before->second.size_m != told.size_m ||
            before->second.height_m != told.height_m)
            news.push_back(reach_of(array_, told, objects.parts.at(i)));
        now.emplace(told.name, told);
    }
    known_ = std::move(now);
    return news;
}

/// The hand where it will be when what it feels plays.
Hand HandFeeler::ahead(Hand hand, double time_s) {
    constexpr std::uint64_t places = 32;  // of a hand: its palm, and four joints of each finger
    const double seen_s = hand.seen_s.value_or(time_s);
    std::uint64_t place = static_cast<std::uint64_t>(hand.id) * places;
    hand.palm = predictor_.ahead(place++, hand.palm, seen_s, time_s);
    for (auto& finger : hand.fingers) {
        if (finger)
            for (Vec3& joint : finger->joints) joint = predictor_.ahead(place++, joint, seen_s, time_s);
        else
            place += 4;
    }
    return hand;
}

Path HandFeeler::pass_of(const Touch& touch, ShotReport& report) {
    std::vector<Voice> voices = touch.voices;
    if (touch.am_hz > 0.0)
        for (Voice& voice : voices) voice.am_hz = touch.am_hz;
    if (keep_felt(array_, voices, dwell / carrier_hz_) && voices.empty())
        report.troubles.emplace_back("all skin that touches faces away from the array");
    if (voices.empty()) return {};
    PathPen pen(array_, carrier_hz_, dwell);
    const Played played = pen.play_pass(voices);
    if (played.out_of_reach > 0) {
        ++counts_.out_of_reach;
        report.troubles.push_back(fmt::format(
            "{:.0f} % of what is felt is out of the array's reach, {}",
            100.0 * static_cast<double>(played.out_of_reach) / static_cast<double>(played.foci), played.why));
    }
    return pen.path();
}

std::optional<Path> HandFeeler::feel(const Frame& frame, ShotReport& report) {
    std::vector<SkinRegion> skin;
    for (const Hand& hand : std::get<HandFrame>(frame.seen).hands) {
        for (SkinRegion& region : palmar_surface(ahead(hand, frame.time_s), options_.skin))
            skin.push_back(std::move(region));
    }
    predictor_.forget_before(frame.time_s - forget_s);
    if (skin.empty()) ++counts_.empty;
    const std::shared_ptr<const ObjectsNow> objects = objects_(frame.time_s);
    const Touch made = touch_of(options_.algorithm, objects->all, skin, frame.time_s, options_.touch);
    report.foci = made.voices.size();
    report.objects = objects->told;
    report.news = news_of(*objects);
    std::vector<std::size_t> touched;
    for (const SkinLine& line : made.lines) {
        std::vector<Vec3>& points = report.contacts.emplace_back();
        for (const SkinPoint& point : opened(line)) points.push_back(point.position);
        touched.push_back(line.region);
    }
    std::sort(touched.begin(), touched.end());
    report.fingers = static_cast<std::size_t>(std::unique(touched.begin(), touched.end()) - touched.begin());
    if (made.voices.empty()) return {};
    Path path = pass_of(made, report);
    if (std::all_of(path.steps.begin(), path.steps.end(), [](const PathStep& step) { return step.foci.empty(); }))
        return {};
    ++counts_.with_rings;
    return path;
}

}  // namespace haptogram::live
