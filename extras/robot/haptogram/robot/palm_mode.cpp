// SPDX-License-Identifier: Apache-2.0
#include "haptogram/robot/palm_mode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram::fusion {
namespace {

constexpr double pi = std::numbers::pi;

void require_sound(const PalmPattern& pattern, std::size_t points) {
    const bool turns = pattern.sign == PalmSign::rotation, grows = pattern.sign == PalmSign::scaling;
    if ((turns && pattern.shape != PalmShape::line) || (grows && pattern.shape == PalmShape::focus))
        throw bad_argument("sign", "rotation is seen of a line only, and scaling of a line or a ring");
    if (pattern.shape != PalmShape::focus && points < 2)
        throw bad_argument("points", fmt::format("a line or a ring needs at least 2, found {}", points));
    if (!(pattern.size_m > 0.0) || !std::isfinite(pattern.low) || !std::isfinite(pattern.high) ||
        (grows && !(pattern.low > 0.0 && pattern.high > 0.0)))
        throw bad_argument("pattern", "its size, and factors of it, must be positive, and its range finite");
}

}  // namespace

PalmSign palm_sign(const std::string& name) {
    for (const auto& [known, sign] :
         {std::pair("intensity", PalmSign::intensity), std::pair("frequency", PalmSign::frequency),
          std::pair("translation", PalmSign::translation), std::pair("rotation", PalmSign::rotation),
          std::pair("scaling", PalmSign::scaling)})
        if (name == known) return sign;
    throw bad_argument(
        "sign", fmt::format("found \"{}\", expected intensity, frequency, translation, rotation or scaling", name));
}

SignRange usual_range(PalmSign sign) {
    switch (sign) {
        case PalmSign::intensity: return {1.0, 4.0};
        case PalmSign::frequency: return {80.0, 300.0};
        case PalmSign::translation: return {-30e-3, 30e-3};
        case PalmSign::rotation: return {0.0, 90.0};
        case PalmSign::scaling: return {0.5, 2.0};
    }
    throw bad_argument("sign", "is none that a pattern has");
}

PalmShape palm_shape(const std::string& name) {
    for (const auto& [known, shape] :
         {std::pair("focus", PalmShape::focus), std::pair("line", PalmShape::line), std::pair("ring", PalmShape::ring)})
        if (name == known) return shape;
    throw bad_argument("pattern", fmt::format("found \"{}\", expected focus, line or ring", name));
}

Stimulus tell(const PalmPattern& pattern, double value, const Hand& palm, std::size_t points) {
    require_sound(pattern, points);
    if (!(value >= 0.0 && value <= 1.0))
        throw bad_argument("value", fmt::format("a pattern tells values of 0…1, found {:g}", value));
    const double told = pattern.low + value * (pattern.high - pattern.low);
    Stimulus stimulus;
    stimulus.magnitude = pattern.sign == PalmSign::intensity ? told : pattern.magnitude;
    stimulus.frequency_hz = pattern.sign == PalmSign::frequency ? told : pattern.frequency_hz;
    const Vec3 along = palm.direction, across = cross(palm.normal, palm.direction);
    const double shift = pattern.sign == PalmSign::translation ? told : 0.0;
    const double turn = pattern.sign == PalmSign::rotation ? told * pi / 180.0 : 0.0;
    const double half = 0.5 * pattern.size_m * (pattern.sign == PalmSign::scaling ? told : 1.0);
    const auto at = [&](double u, double v) {
        stimulus.points.push_back(palm.palm + (shift + u) * along + v * across);
    };
    if (pattern.shape == PalmShape::focus) {
        at(0.0, 0.0);
        return stimulus;
    }
    for (std::size_t i = 0; i < points; ++i) {
        const auto number = static_cast<double>(i);
        if (pattern.shape == PalmShape::ring) {
            const double angle = 2.0 * pi * number / static_cast<double>(points);
            at(half * std::cos(angle), half * std::sin(angle));
        } else {
            const double place = half * (2.0 * number / static_cast<double>(points - 1) - 1.0);
            at(place * std::cos(turn), place * std::sin(turn));
        }
    }
    return stimulus;
}

double nearness(double distance_m, double range_m) {
    if (!(range_m > 0.0)) throw bad_argument("range", fmt::format("must be above 0 m, found {:g} m", range_m));
    return std::max(0.0, 1.0 - std::abs(distance_m) / range_m);
}

double cloth(double x_m, double y_m, double cell_m) {
    if (!(cell_m > 0.0)) throw bad_argument("cell", fmt::format("must be above 0 m, found {:g} m", cell_m));
    return 0.5 + 0.5 * std::sin(2.0 * pi * x_m / cell_m) * std::sin(2.0 * pi * y_m / cell_m);
}

double hardness(double stiffness_n_m, double softest_n_m, double hardest_n_m) {
    if (!(softest_n_m > 0.0 && softest_n_m < hardest_n_m && stiffness_n_m >= softest_n_m &&
          stiffness_n_m <= hardest_n_m))
        throw bad_argument("stiffness", fmt::format("found {:g} N/m, expected it between the softest, {:g} N/m, and "
                                                    "the hardest, {:g} N/m, that are told",
                                                    stiffness_n_m, softest_n_m, hardest_n_m));
    return std::log(stiffness_n_m / softest_n_m) / std::log(hardest_n_m / softest_n_m);
}

}  // namespace haptogram::fusion
