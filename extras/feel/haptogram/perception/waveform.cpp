// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/waveform.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram::perception {
namespace {

using std::numbers::pi;

constexpr std::array<std::pair<Waveform, const char*>, 6> names = {{{Waveform::square, "square"},
                                                                    {Waveform::abs_sine, "abs-sine"},
                                                                    {Waveform::sine, "sine"},
                                                                    {Waveform::cosine, "cosine"},
                                                                    {Waveform::triangle, "triangle"},
                                                                    {Waveform::sawtooth, "sawtooth"}}};

void require_duty(double duty) {
    if (!(duty > 0.0 && duty <= 1.0))
        throw bad_argument("duty", fmt::format("the duty of a square wave lies above 0 and up to 1, found {:g}", duty));
}

double output(Waveform waveform, double duty, Weighing weighing) {
    return weighing == Weighing::mean ? mean_output(waveform, duty) : fundamental_output(waveform, duty);
}

}  // namespace

std::string name_of(Waveform waveform) {
    for (const auto& [which, name] : names)
        if (which == waveform) return name;
    throw bad_argument("waveform", "no such waveform");
}

Waveform waveform_of(const std::string& name) {
    std::string known;
    for (const auto& [which, text] : names) {
        if (name == text) return which;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", text);
    }
    throw bad_argument("waveform", fmt::format("expected one of {}, found '{}'", known, name));
}

const std::vector<Waveform>& all_waveforms() {
    static const std::vector<Waveform> all = [] {
        std::vector<Waveform> list;
        for (const auto& entry : names) list.push_back(entry.first);
        return list;
    }();
    return all;
}

double envelope(Waveform waveform, double phase, double duty) {
    const double t = phase - std::floor(phase);
    switch (waveform) {
        case Waveform::square: require_duty(duty); return t < duty ? 1.0 : 0.0;
        case Waveform::abs_sine: return std::abs(std::sin(pi * t));
        case Waveform::sine: return (1.0 + std::sin(2.0 * pi * t)) / 2.0;
        case Waveform::cosine: return (1.0 + std::cos(2.0 * pi * t)) / 2.0;
        case Waveform::triangle: return 1.0 - std::abs(2.0 * t - 1.0);
        case Waveform::sawtooth: return t;
    }
    throw bad_argument("waveform", "no such waveform");
}

double mean_output(Waveform waveform, double duty) {
    switch (waveform) {
        case Waveform::square: require_duty(duty); return duty;
        case Waveform::abs_sine: return 1.0 / 2.0;
        case Waveform::sine:
        case Waveform::cosine: return 3.0 / 8.0;
        case Waveform::triangle:
        case Waveform::sawtooth: return 1.0 / 3.0;
    }
    throw bad_argument("waveform", "no such waveform");
}

double fundamental_output(Waveform waveform, double duty) {
    // Fourier coefficients of m², at the frequency at which the envelope repeats.
    switch (waveform) {
        case Waveform::square: require_duty(duty); return 2.0 / pi * std::sin(pi * duty);
        case Waveform::abs_sine: return 1.0 / 2.0;
        case Waveform::sine:
        case Waveform::cosine: return 1.0 / 2.0;
        case Waveform::triangle: return 4.0 / (pi * pi);
        case Waveform::sawtooth: return std::hypot(1.0 / (pi * pi), 1.0 / pi);
    }
    throw bad_argument("waveform", "no such waveform");
}

Weighing weighing_of(const std::string& name) {
    if (name == "fundamental") return Weighing::fundamental;
    if (name == "mean") return Weighing::mean;
    throw bad_argument("weighing", fmt::format("expected fundamental or mean, found '{}'", name));
}

double waveform_factor(Waveform waveform, Weighing weighing) {
    return output(waveform, 0.5, weighing) / output(Waveform::square, 0.5, weighing);
}

double duty_factor(double duty, Weighing weighing) {
    require_duty(duty);
    if (duty == 1.0 && weighing == Weighing::fundamental)
        throw bad_argument("duty",
                           "a square wave of duty 1 does not alternate, so it is not felt as vibration; take less");
    return output(Waveform::square, 0.5, weighing) / output(Waveform::square, duty, weighing);
}

double radiation_linear(double wanted) {
    if (!(wanted >= 0.0 && wanted <= 1.0))
        throw bad_argument("wanted",
                           fmt::format("a radiation pressure as a part of the largest is 0…1, found {:g}", wanted));
    return std::sqrt(wanted);
}

}  // namespace haptogram::perception
