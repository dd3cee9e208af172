// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/analyze.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"

namespace haptogram {
namespace {

/// How far from its middle an array can make a focus: its near field, the square of its width over four wavelengths.
/// Beyond it, whatever the phases are, the sound is strongest nearer to the array.
double farthest_focus(const Array& array) {
    Vec3 low = array.elements.front().position, high = low;
    for (const Element& element : array.elements) {
        const Vec3& p = element.position;
        low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    // Across a square; the way from corner to corner is longer.
    const double width = norm(high - low) / std::numbers::sqrt2 + 2.0 * array.transducer.radius_m;
    return width * width / 4.0 / array.wavelength_m();
}

Vec3 middle_of(const Array& array) {
    Vec3 sum{};
    for (const Element& element : array.elements) sum = sum + element.position;
    return sum * (1.0 / static_cast<double>(array.elements.size()));
}

/// The least of warmer and colder air.
double left_in_other_air(const Array& array, Vec3 focus) {
    constexpr double zero_k = 273.15;
    const double ratio = array.medium.speed_m_s / speed_of_sound(0.0), temperature_c = zero_k * (ratio * ratio - 1.0);
    return std::min(left_at_speed(array, focus, speed_of_sound(temperature_c + other_air_c)),
                    left_at_speed(array, focus, speed_of_sound(temperature_c - other_air_c)));
}

}  // namespace

double left_at_speed(const Array& array, Vec3 focus, double speed_m_s) {
    const double turns_per_m = array.carrier_hz / speed_m_s - array.carrier_hz / array.medium.speed_m_s;
    std::complex<double> sum;
    double whole = 0.0;
    for (const Element& element : array.elements) {
        const double pressure = std::abs(propagation(array, element, focus));
        sum += std::polar(pressure, 2.0 * std::numbers::pi * turns_per_m * distance(element, focus));
        whole += pressure;
    }
    return whole > 0.0 ? std::abs(sum) / whole : 1.0;
}

ImageAnalysis analyze(const Timeline& timeline, double least_force_n, const Progress& progress) {
    const Manifest& manifest = timeline.manifest;
    const std::vector<FocusDrives> sets = foci_of(timeline);
    const Path places = places_of(timeline);
    const bool rests = places.steps.size() == 1;  // nothing follows it
    ImageAnalysis result;
    result.transducer = timeline.manifest.array.transducer;
    std::size_t weak = 0;
    std::size_t short_dwells = 0;
    std::size_t unheard = 0;
    std::size_t far = 0;
    const double farthest = farthest_focus(manifest.array);
    const Vec3 middle = middle_of(manifest.array);
    for (std::size_t i = 0; i < sets.size(); ++i) {
        if (sets[i].drives.empty()) ++unheard;
        for (const Focus& focus : sets[i].foci) {
            if (sets[i].drives.empty()) continue;
            PointAnalysis point{sets[i].record, analyze(manifest.array, manifest.core, sets[i].drives, focus.position),
                                sets[i].periods};
            // P = 2·I/c on skin, where the intensity is highest.
            const double highest_pa = 2.0 * safe_in_tissue_w_m2 / absorbed_by_skin / manifest.array.medium.speed_m_s;
            point.heat_limit_n = point.focus.force_n * highest_pa / point.focus.radiation_pa;
            point.impulse_ns =
                point.focus.force_n * static_cast<double>(point.dwell_cycles) / manifest.array.carrier_hz;
            point.left_in_other_air = left_in_other_air(manifest.array, focus.position);
            point.too_weak = point.focus.force_n < least_force_n;
            far += norm(focus.position - middle) > farthest ? 1 : 0;
            weak += point.too_weak ? 1 : 0;
            short_dwells += !rests && point.dwell_cycles < point.focus.dwell_cycles ? 1 : 0;
            result.points.push_back(point);
        }
        progress(static_cast<double>(i + 1) / static_cast<double>(sets.size()));
    }
    const std::size_t points = result.points.size();
    if (unheard > 0)
        result.warnings.push_back(fmt::format(
            "{} of {} sets of foci have no pulse in what was measured; simulate a whole pass", unheard, sets.size()));
    if (far > 0)
        result.warnings.push_back(fmt::format(
            "{} of {} points are no foci: beyond {:.0f} mm, the near field of an array of this width, the sound is "
            "strongest nearer to it; bring them closer, or take a wider array",
            far, points, farthest / millimetre));
    if (weak > 0)
        result.warnings.push_back(fmt::format("{} of {} points may be too weak to feel: less than {} mN in their focus",
                                              weak, points, least_force_n * 1e3));
    if (short_dwells > 0)
        result.warnings.push_back(fmt::format(
            "{} of {} points are left before 90 % of their pressure is there; take fewer points or a lower rate",
            short_dwells, points));
    if (!places.steps.empty()) result.pressure_left = summary_of(places, pressure_left(manifest.array, places));
    result.loudness = loudness(manifest.array, excitation_of(timeline).sequence());
    return result;
}

}  // namespace haptogram
