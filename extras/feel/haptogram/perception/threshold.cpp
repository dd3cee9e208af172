// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/threshold.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/perception/magnitude.hpp"

namespace haptogram::perception {
namespace {

const Interval& interval_of(const ThresholdRow& row, Region region) {
    return region == Region::palm ? row.palm : row.finger;
}

/// Where x lies between a and b on a logarithmic scale: 0 at a, 1 at b.
double log_place(double x, double a, double b) { return std::log(x / a) / std::log(b / a); }

}  // namespace

Region region_of(const std::string& name) {
    if (name == "palm") return Region::palm;
    if (name == "finger") return Region::finger;
    throw bad_argument("region", fmt::format("expected palm or finger, found '{}'", name));
}

Interval threshold_interval(const Tables& tables, Region region, double grip_n) {
    const auto& rows = tables.thresholds;
    if (!(grip_n >= rows.front().grip_n && grip_n <= rows.back().grip_n))
        throw bad_argument(
            "grip", fmt::format("{:g} N lies outside of {:g}…{:g} N, which {} covers; for a bare hand take "
                                "{:g} N, whose threshold is an upper bound",
                                grip_n, rows.front().grip_n, rows.back().grip_n, tables.name, rows.front().grip_n));
    const auto above =
        std::find_if(rows.begin() + 1, rows.end(), [&](const ThresholdRow& row) { return row.grip_n >= grip_n; });
    const ThresholdRow& below = *(above - 1);
    const double place = log_place(grip_n, below.grip_n, above->grip_n);
    const Interval &a = interval_of(below, region), &b = interval_of(*above, region);
    return {std::lerp(a.low_gf, b.low_gf, place), std::lerp(a.high_gf, b.high_gf, place)};
}

double least_felt_gf(const Tables& tables, Region region, double frequency_hz, double grip_n) {
    const Interval interval = threshold_interval(tables, region, grip_n);
    (void)fit_at(tables, frequency_hz);  // refuses what the tables do not cover
    double place = 0.0;
    if (frequency_hz < tables.most_sensitive_from_hz)
        place = log_place(frequency_hz, tables.most_sensitive_from_hz, tables.fits.front().frequency_hz);
    else if (frequency_hz > tables.most_sensitive_to_hz)
        place = log_place(frequency_hz, tables.most_sensitive_to_hz, tables.fits.back().frequency_hz);
    return std::lerp(interval.low_gf, interval.high_gf, place);
}

ThresholdLaw threshold_law(const Tables& tables, Region region) {
    const auto count = static_cast<double>(tables.thresholds.size());
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    for (const ThresholdRow& row : tables.thresholds) {
        const double log_force = std::log(row.grip_n), centre = interval_of(row, region).centre_gf();
        x += log_force;
        y += centre;
        xx += log_force * log_force;
        xy += log_force * centre;
    }
    ThresholdLaw law;
    law.b_gf = (count * xy - x * y) / (count * xx - x * x);
    law.a_gf = (y - law.b_gf * x) / count;
    for (const ThresholdRow& row : tables.thresholds)
        law.largest_residual_gf =
            std::max(law.largest_residual_gf,
                     std::abs(interval_of(row, region).centre_gf() - law.a_gf - law.b_gf * std::log(row.grip_n)));
    return law;
}

double least_displacement_db(double frequency_hz, double area_factor) {
    constexpr double pacinian_db = -20.0, other_db = 12.5, other_to_hz = 40.0, best_hz = 250.0, rises_hz = 300.0;
    constexpr double per_decade_db = 40.0;  // 12 dB an octave
    if (!(frequency_hz >= lowest_vibration_hz && frequency_hz <= highest_vibration_hz))
        throw bad_argument("frequency", fmt::format("{:g} Hz lies outside of {:g}…{:g} Hz", frequency_hz,
                                                    lowest_vibration_hz, highest_vibration_hz));
    if (!(area_factor > 0.0 && std::isfinite(area_factor)))
        throw bad_argument("area_factor", fmt::format("must be a positive number, found {:g}", area_factor));
    double pacinian = pacinian_db - 10.0 * std::log10(area_factor);
    if (frequency_hz < best_hz) pacinian += per_decade_db * std::log10(best_hz / frequency_hz);
    if (frequency_hz > rises_hz) pacinian += per_decade_db * std::log10(frequency_hz / rises_hz);
    return frequency_hz <= other_to_hz ? std::min(pacinian, other_db) : pacinian;
}

}  // namespace haptogram::perception
