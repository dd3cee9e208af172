// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/focus_analysis.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

/// Of the lines on which a focus is measured: it grows with the focus's distance, so that there are so many steps at
/// most.
double step_to(Vec3 focus) { return std::max(0.1e-3, focus.z / 20'000.0); }

std::vector<double> steps(double from, double to, double step_m) {
    std::vector<double> values;
    const auto count = static_cast<std::size_t>(std::max(0.0, std::floor((to - from) / step_m))) + 1;
    for (std::size_t i = 0; i < count; ++i) values.push_back(from + static_cast<double>(i) * step_m);
    return values;
}

/// Radiation pressure along a line, to within a factor.
std::vector<float> squares(const Array& array, Drives drives, const Grid& line) {
    std::vector<float> found;
    for (const std::complex<float> p : pressure_on(array, drives, line)) found.push_back(std::norm(p));
    return found;
}

/// The main lobe of a line around `start`, which need not be its peak: where it falls to half, and to its first minima.
struct Lobe {
    std::size_t peak, half_low, half_high, low, high;
};

Lobe main_lobe(const std::vector<float>& line, std::size_t start) {
    std::size_t peak = start;
    while (peak + 1 < line.size() && line[peak + 1] > line[peak]) ++peak;
    while (peak > 0 && line[peak - 1] > line[peak]) --peak;
    Lobe lobe{peak, peak, peak, peak, peak};
    while (lobe.half_low > 0 && line[lobe.half_low] > line[peak] / 2) --lobe.half_low;
    while (lobe.half_high + 1 < line.size() && line[lobe.half_high] > line[peak] / 2) ++lobe.half_high;
    while (lobe.low > 0 && line[lobe.low - 1] < line[lobe.low]) --lobe.low;
    while (lobe.high + 1 < line.size() && line[lobe.high + 1] < line[lobe.high]) ++lobe.high;
    return lobe;
}

/// The distance between the two places of half the peak, interpolated between the points of the line.
double width(const std::vector<float>& line, const Lobe& lobe, double step_m) {
    const auto crossing = [&](std::size_t below, std::size_t above) {
        const float half = line[lobe.peak] / 2;
        return line[above] == line[below] ? 0.0
                                          : static_cast<double>((half - line[below]) / (line[above] - line[below]));
    };
    const double low = static_cast<double>(lobe.half_low) +
                       (line[lobe.half_low] < line[lobe.peak] / 2 ? crossing(lobe.half_low, lobe.half_low + 1) : 0.0);
    const double high =
        static_cast<double>(lobe.half_high) -
        (line[lobe.half_high] < line[lobe.peak] / 2 ? crossing(lobe.half_high, lobe.half_high - 1) : 0.0);
    return (high - low) * step_m;
}

}  // namespace

FocusAnalysis analyze(const Array& array, const Core& core, Drives drives, Vec3 focus) {
    FocusAnalysis result;
    result.focus = focus;
    result.formation = formation(array, core, focus);
    const std::complex<double> p = pressure(array, drives, focus);
    result.pressure_pa = std::abs(p);
    result.radiation_pa = radiation_pressure(p, array.medium);
    const double step_m = step_to(focus);
    // Wide enough for the first grating lobes of half a wavelength's pitch or more.
    const double reach = 0.6 * focus.z + 20e-3;
    for (const bool along_x : {true, false}) {
        const std::vector<double> axis =
            steps((along_x ? focus.x : focus.y) - reach, (along_x ? focus.x : focus.y) + reach, step_m);
        const Grid line = along_x ? Grid{axis, {focus.y}, {focus.z}} : Grid{{focus.x}, axis, {focus.z}};
        const std::vector<float> values = squares(array, drives, line);
        const Lobe lobe = main_lobe(values, values.size() / 2);
        result.width_m = std::max(result.width_m, width(values, lobe, step_m));
        const auto begin = values.begin();
        const float beside = std::max(*std::max_element(begin, begin + static_cast<std::ptrdiff_t>(lobe.low) + 1),
                                      *std::max_element(begin + static_cast<std::ptrdiff_t>(lobe.high), values.end()));
        result.side_lobe = std::max(result.side_lobe, static_cast<double>(beside / values[lobe.peak]));
    }
    const std::vector<double> z = steps(array.wavelength_m(), 3.0 * focus.z, step_m);
    const std::vector<float> values = squares(array, drives, {{focus.x}, {focus.y}, z});
    const auto at = static_cast<std::size_t>(std::lower_bound(z.begin(), z.end(), focus.z) - z.begin());
    result.depth_m = width(values, main_lobe(values, std::min(at, values.size() - 1)), step_m);
    result.force_n = steady_force(array, drives, focus);
    result.dwell_cycles = static_cast<std::uint32_t>(std::ceil(result.formation.with_ring_up_s() * array.carrier_hz));
    return result;
}

double reachable_pressure(const Array& array, Vec3 point) {
    if (!array.unreachable(point).empty()) return std::numeric_limits<double>::quiet_NaN();
    double sum = 0.0;
    for (const Element& element : array.elements) sum += std::abs(propagation(array, element, point));
    return sum * array.transducer.source_pa_m;
}

std::vector<float> workspace(const Array& array, const Grid& grid) {
    std::vector<float> found;
    found.reserve(grid.size());
    for (std::size_t i = 0; i < grid.size(); ++i)
        found.push_back(static_cast<float>(reachable_pressure(array, grid.point(i))));
    return found;
}

std::vector<Vec3> felt_places(const Array& array, const Grid& grid, double least_force_n) {
    std::vector<Vec3> found;
    for (std::size_t i = 0; i < grid.size(); ++i)
        if (const Vec3 place = grid.point(i);
            array.unreachable(place).empty() && full_force(array, place) >= least_force_n)
            found.push_back(place);
    return found;
}

Loudness loudness(const Array& array, std::span<const WeightedDrives> sequence) {
    constexpr double ear_m = 0.3;
    constexpr double farthest_m = 1.0;
    constexpr double apart_m = 1e-3;
    std::vector<double> z(static_cast<std::size_t>((farthest_m - array.wavelength_m()) / apart_m));
    for (std::size_t i = 0; i < z.size(); ++i) z[i] = array.wavelength_m() + static_cast<double>(i) * apart_m;
    z.push_back(ear_m);
    const std::vector<float> square = mean_square_pressure(array, sequence, {{0.0}, {0.0}, z});
    const auto highest = static_cast<std::size_t>(std::max_element(square.begin(), square.end()) - square.begin());
    const double top = square[highest];
    return {sound_level_db(std::sqrt(2.0 * top)), z[highest], sound_level_db(std::sqrt(2.0 * square.back())),
            top / (array.medium.density_kg_m3 * array.medium.speed_m_s)};
}

std::vector<WeightedDrives> Excitation::sequence() const {
    std::vector<WeightedDrives> found;
    for (std::size_t i = 0; i < drives.size(); ++i) found.push_back({weights[i], drives[i]});
    return found;
}

void weaken(Excitation& excitation, double factor) {
    for (std::vector<std::complex<double>>& drives : excitation.drives)
        for (std::complex<double>& drive : drives) drive *= factor;
}

Excitation excitation_of(const Array& array, Vec3 focus) {
    if (const std::string why = array.unreachable(focus); !why.empty()) throw bad_argument("focus", why);
    return {array,
            {ideal_drives(array, focus)},
            {1.0},
            {focus},
            fmt::format("{}, exact phases for ({:g},{:g},{:g}) mm", array.name, focus.x / millimetre,
                        focus.y / millimetre, focus.z / millimetre)};
}

Excitation only(const Excitation& excitation, std::size_t place) {
    if (place >= excitation.drives.size())
        throw bad_argument("record",
                           fmt::format("there are {} sets of drives, not {}", excitation.drives.size(), place + 1));
    return {excitation.array, {excitation.drives[place]}, {1.0}, {}, excitation.title};
}

Envelope envelope_of(std::span<const Pulse> pulses, double clock_hz, std::uint64_t cycle_clocks, bool silent_before) {
    std::map<std::uint32_t, std::vector<std::uint64_t>> rises;
    for (const Pulse& pulse : pulses) rises[pulse.channel].push_back(pulse.rise);
    const auto most = std::max_element(rises.begin(), rises.end(),
                                       [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    Envelope envelope;
    if (most == rises.end()) return envelope;
    const std::vector<std::uint64_t>& times = most->second;
    std::vector<std::uint64_t> begins;
    for (std::size_t i = silent_before ? 1 : 0; i < times.size(); ++i)
        if (i == 0 || 2 * (times[i] - times[i - 1]) > 3 * cycle_clocks) begins.push_back(times[i]);
    envelope.bursts = begins.size();
    if (begins.size() >= 2)
        envelope.frequency_hz =
            static_cast<double>(begins.size() - 1) * clock_hz / static_cast<double>(begins.back() - begins.front());
    return envelope;
}

double share_of_full_drive(const Array& array, std::span<const std::complex<double>> drives, Vec3 focus) {
    return std::abs(pressure(array, drives, focus)) / std::abs(pressure(array, ideal_drives(array, focus), focus));
}

}  // namespace haptogram
