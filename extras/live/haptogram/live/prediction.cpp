// SPDX-License-Identifier: Apache-2.0
#include "haptogram/live/prediction.hpp"

#include <fmt/format.h>

#include "haptogram/base/error.hpp"

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

}  // namespace haptogram::live
