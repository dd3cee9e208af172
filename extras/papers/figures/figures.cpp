// SPDX-License-Identifier: Apache-2.0
// What extras/papers/figures.py needs beyond the command line: transducers in time, elevations below the far field, and
// Hoshi's closed forms. Prints one JSON object; nothing in it is fitted to a paper but the one bandwidth of
// frequency_response().
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/transient.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/movement.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/segments.hpp"
#include "haptogram/solve/solver.hpp"

namespace {

using namespace haptogram;
using Json = nlohmann::ordered_json;
using std::numbers::pi;

constexpr double millimetre = 1e-3;
constexpr double microsecond = 1e-6;

Json to_json(const RingUp& up) {
    return {{"first_arrival_us", up.first_arrival_s / microsecond},
            {"flight_spread_us", up.flight_spread_s / microsecond},
            {"ring_up_90_us", up.ring_up_s / microsecond},
            {"formation_90_us", up.rise_s / microsecond}};
}

/// The pressure at a point and its envelope, from when the trains begin to play.
Json envelope_at(const Array& array, const Resonator& resonator, std::span<const std::vector<DrivePulse>> trains,
                 Vec3 point, double duration_s, std::size_t samples_per_period) {
    const double step = 1.0 / array.carrier_hz / static_cast<double>(samples_per_period);
    const auto count = static_cast<std::size_t>(std::ceil(duration_s / step));
    const auto wave = pressure_over_time(array, resonator, trains, point, {0.0, step, count});
    Json found{{"step_us", step / microsecond}, {"envelope_pa", Json::array()}};
    for (const auto& value : envelope(wave, samples_per_period)) found["envelope_pa"].push_back(std::abs(value));
    found["pressure_pa"] = wave;
    return found;
}

Json formation_over_time(const Array& tile) {
    const Resonator resonator = second_order(tile);
    Json found;
    for (const double height : {100.0, 150.0}) {
        const Vec3 focus{0.0, 0.0, height * millimetre};
        const Formation law = formation(tile, core_of_array(tile.file), focus);
        found["foci"].push_back({{"elevation_mm", height},
                                 {"beta", law.periods},
                                 {"t_f_us", law.formation_s / microsecond},
                                 {"second_order", to_json(ring_up(tile, resonator, focus))},
                                 {"butterworth_van_dyke", to_json(ring_up(tile, butterworth_van_dyke(), focus))}});
    }
    const Vec3 focus{0.0, 0.0, 150.0 * millimetre};
    found["bandwidth_hz"] = tile.transducer.bandwidth_hz;
    found["time_constant_us"] = resonator.time_constant_s() / microsecond;
    found["at_150_mm"] = envelope_at(tile, resonator, focal_trains(tile, focus, 0, 120), focus, 2.4e-3, 20);
    return found;
}

Json alternation(const Array& tile) {
    const Vec3 focus{-25.0 * millimetre, 0.0, 130.0 * millimetre};
    const Vec3 other{25.0 * millimetre, 0.0, 130.0 * millimetre};
    Json found = Json::array();
    for (const std::size_t periods : {1U, 2U, 4U, 8U, 16U, 26U, 40U, 80U}) {
        const Alternation kept = alternate(tile, second_order(tile), focus, other, periods);
        found.push_back({{"dwell_us", static_cast<double>(periods) / tile.carrier_hz / microsecond},
                         {"peak", kept.peak},
                         {"power", kept.power}});
    }
    return found;
}

/// Pressure amplitude of a focus on the axis, with exact phases, against its elevation.
Json elevations(const Array& tile) {
    Array point = tile;
    point.transducer.pattern = Pattern::point;
    Array measured = tile;  // another transducer's measured pattern; this one's source strength
    const Transducer other = find_transducer("T4010A1");
    measured.transducer.pattern = other.pattern;
    measured.transducer.table = other.table;
    // Through a receiver of the same pattern that faces the array, as the paper's probe did.
    const auto heard = [&](Vec3 focus) {
        const double k = 2.0 * pi / tile.wavelength_m();
        double sum = 0.0;
        for (const Element& e : tile.elements)
            sum += tile.transducer.source_pa_m * std::abs(propagation(tile, e, focus)) *
                   std::abs(directivity(tile.transducer, k, focus.z / distance(e, focus)));
        return sum;
    };
    Json found{{"far_field_mm", tile.nearest_m / millimetre}, {"source_pa_m", tile.transducer.source_pa_m}};
    for (int z = 10; z <= 200; z += 2) {
        const Vec3 focus{0.0, 0.0, z * millimetre};
        found["z_mm"].push_back(z);
        found["heard_pa"].push_back(heard(focus));
        for (const auto& [name, array] : {std::pair<const char*, const Array&>{"piston_pa", tile},
                                          {"point_pa", point},
                                          {"t4010a1_pattern_pa", measured}})
            found[name].push_back(std::abs(pressure(array, ideal_drives(array, focus), focus)));
    }
    return found;
}

/// Hoshi eq. 4, second line: N × N sources in the Fresnel approximation, rms pressure p_r each.
double hoshi_eq4(double x, double y, double p_r, double pitch, double k, double r) {
    const auto factor = [&](double u) {
        const double half = k * pitch * u / r / 2.0;
        return std::abs(half) < 1e-9 ? 18.0 : std::sin(18.0 * half) / std::sin(half);
    };
    return std::numbers::sqrt2 * p_r * factor(x) * factor(y);
}

Json hoshi_focus(const Array& hoshi) {
    const double r = 200.0 * millimetre;
    const double pitch = 10.0 * millimetre;
    const double wavelength = hoshi.wavelength_m();
    const double k = 2.0 * pi / wavelength;
    const double width = focal_diameter(wavelength, r, 18.0 * pitch);
    const auto field = [&](Vec3 at) { return std::complex<double>(hoshi_eq4(at.x, at.y, 36.0, pitch, k, r)); };
    Json found{{"w_f_mm", width / millimetre}, {"w_d_mm", focal_depth(wavelength, r, 18.0 * pitch) / millimetre}};
    found["force_mn"] = force_through_square(field, hoshi.medium, {}, width, wavelength / 2.0) * 1e3;
    double lobe = 0.0;
    for (int i = -900; i <= 900; ++i) {
        const double x = i * 5e-5;
        const double relative = std::norm(field({x, 0.0, 0.0})) / std::norm(field({}));
        if (std::abs(x) > width / 2.0 && std::abs(x) < 1.5 * width) lobe = std::max(lobe, relative);
        found["eq4_x_mm"].push_back(x / millimetre);
        found["eq4_radiation"].push_back(relative);
    }
    found["side_lobe"] = lobe;
    // Without the Fresnel approximation: spherical waves, 36 Pa rms at 200 mm on each one's axis.
    const Vec3 focus{0.0, 0.0, r};
    Array exact = hoshi;
    exact.transducer.source_pa_m = 36.0 * std::numbers::sqrt2 * r;
    const auto force = [&](const Array& array) {
        return force_through_square(array, ideal_drives(array, focus), focus, width) * 1e3;
    };
    found["force_pattern_mn"] = force(exact);
    // Phases in 16 steps a period, as its FPGAs made them.
    auto drives = ideal_drives(exact, focus);
    for (auto& drive : drives) drive = std::polar(std::abs(drive), std::round(std::arg(drive) / (pi / 8)) * (pi / 8));
    found["force_16_steps_mn"] = force_through_square(exact, drives, focus, width) * 1e3;
    exact.transducer.pattern = Pattern::point;
    found["force_spherical_mn"] = force(exact);
    const double one = 24.0 * std::numbers::sqrt2;
    found["one_level_db"] = sound_level_db(one);
    found["hundred_radiation_pa"] = radiation_pressure(100.0 * one, hoshi.medium);
    return found;
}

/// Fig. 3: energy lost on 200 mm, with the paper's law and with the standard's.
Json energy_loss() {
    Json found;
    const double at_40 = db_to_np(1.0);  // 100 dB in 100 m
    const auto lost = [](double absorption, double distance) { return 1.0 - std::exp(-2.0 * absorption * distance); };
    for (int khz = 10; khz <= 200; khz += 2) {
        const double f = khz * 1e3;
        found["khz"].push_back(khz);
        found["hoshi"].push_back(lost(at_40 * f * f / 1.6e9, 0.2));
        found["iso_9613_1"].push_back(lost(absorption_np_m(f, 20.0, 50.0), 0.2));
    }
    found["absorption_40_khz_np_m"] = at_40;
    found["iso_absorption_40_khz_np_m"] = absorption_np_m(40e3, 20.0, 50.0);
    found["lost_40_khz"] = lost(at_40, 0.2);
    found["lost_160_khz"] = lost(16.0 * at_40, 0.2);
    found["iso_lost_40_khz"] = lost(absorption_np_m(40e3, 20.0, 50.0), 0.2);
    found["iso_lost_160_khz"] = lost(absorption_np_m(160e3, 20.0, 50.0), 0.2);
    found["kept_at_400_mm"] = 1.0 - lost(at_40, 0.4);
    return found;
}

/// Fig. 12a: one period of the 100 Hz modulation, from silence.
Json modulation(const Array& hoshi) {
    const Vec3 focus{0.0, 0.0, 200.0 * millimetre};
    Json found = envelope_at(hoshi, second_order(hoshi), focal_trains(hoshi, focus, 0, 200), focus, 10e-3, 10);
    const RingUp up = ring_up(hoshi, second_order(hoshi), focus);
    found["second_order"] = to_json(up);
    found["radiation_of_1_pa"] = radiation_pressure(1.0, hoshi.medium);
    return found;
}

/// Section 3.1 and eq. 7: pulses of whole segments, what they radiate, and what 16 phases keep of a focus' pressure.
Json quantised_drive(const Array& hoshi) {
    constexpr double segment_s = 25e-6 / 16.0;
    Json found;
    for (std::uint32_t length = 0; length <= 8; ++length) {
        const DrivePulse pulse{0.0, length * segment_s};
        found["carrier"].push_back(length == 0 ? 0.0 : std::abs(carrier_component({&pulse, 1}, 40e3, 25e-6)));
        found["drive"].push_back(std::abs(drive_of({0, length}, hoshi_segments)));
    }
    std::vector<double> kept;
    for (const Vec3 position : PositionGrid{}.positions()) {
        const Focus focus{position};
        const auto exact = superposed_drives(hoshi, {&focus, 1});
        kept.push_back(std::abs(pressure(hoshi, in_segments(exact, hoshi_segments), position)) /
                       std::abs(pressure(hoshi, exact, position)));
    }
    double sum = 0.0;
    for (const double one : kept) sum += one;
    found["kept_mean"] = sum / static_cast<double>(kept.size());
    found["kept_least"] = *std::min_element(kept.begin(), kept.end());
    // One row of elements, for a focus above the centre.
    const Focus focus{{0.0, 0.0, 0.2}};
    const auto drives = superposed_drives(hoshi, {&focus, 1});
    for (std::size_t column = 9; column < 18; ++column) {
        const std::size_t m = 9 * 18 + column;
        const SegmentPulse pulse = segment_pulse(drives[m], hoshi_segments);
        found["row"].push_back({{"x_mm", hoshi.elements[m].position.x / millimetre},
                                {"start", pulse.start},
                                {"length", pulse.length},
                                {"exact_start", std::fmod(-std::arg(drives[m]) / (2.0 * pi) * 16.0 + 16.0, 16.0)}});
    }
    return found;
}

/// The fundamental of the squared envelope while the carrier is on for `half` periods and off for as many, again and
/// again: by the resonator itself, over one settled period.
double fundamental(double bandwidth_hz, std::size_t half) {
    constexpr std::size_t samples = 4;  // a carrier period
    const std::size_t cycle = 2 * half, settle = (200 / cycle + 2) * cycle;
    std::vector<DrivePulse> pulses;
    for (std::size_t i = 0; i < settle + cycle + half; ++i)
        if (i / half % 2 == 0) pulses.push_back({static_cast<double>(i) / 40e3, (static_cast<double>(i) + 0.5) / 40e3});
    const auto wave = output(second_order(40e3, bandwidth_hz), pulses,
                             {0.0, 1.0 / 40e3 / samples, samples * (settle + cycle + half)});
    const auto amplitude = envelope(wave, samples);
    std::complex<double> sum = 0.0;
    for (std::size_t i = 0; i < cycle * samples; ++i)
        sum += std::norm(amplitude[settle * samples + i]) *
               std::polar(1.0, -2.0 * pi * static_cast<double>(i) / static_cast<double>(cycle * samples));
    return std::abs(sum) / static_cast<double>(cycle * samples);
}

/// Fig. 12c: the radiation pressure over the modulation's frequency, with the bandwidth that the paper prints, and with
/// the one that gives its −5.8 dB at 1 kHz.
Json frequency_response() {
    const auto response_db = [](double bandwidth, std::size_t half) {
        return 20.0 * std::log10(fundamental(bandwidth, half) / fundamental(bandwidth, 2000));  // 10 Hz
    };
    double low = 500.0, high = 2000.0;
    for (int i = 0; i < 20; ++i) {
        const double middle = 0.5 * (low + high);
        (response_db(middle, 20) > -5.8 ? high : low) = middle;
    }
    Json found{{"fitted_hz", high}, {"printed_hz", 2000.0}};
    const double tau = second_order(40e3, high).time_constant_s();
    found["fitted_tau_us"] = tau / microsecond;
    found["fitted_envelope_90_ms"] = tau * std::log(10.0) * 1e3;
    found["fitted_radiation_95_ms"] = -tau * std::log(1.0 - std::sqrt(0.95)) * 1e3;
    for (const double hertz : hoshi_frequencies_hz()) {
        if (hertz < 9.0) continue;
        const auto half = static_cast<std::size_t>(std::lround(20e3 / hertz));
        found["hz"].push_back(20e3 / static_cast<double>(half));
        found["printed_db"].push_back(response_db(2000.0, half));
        found["fitted_db"].push_back(response_db(high, half));
    }
    for (const std::size_t half : {100U, 40U, 20U}) found["printed_at"].push_back(response_db(2000.0, half));
    return found;
}

/// Eq. 9: spots 20 mm left and right of the axis, and the first copy of a single focus. Pressures are over that of a
/// single focus.
Json pattern(const Array& hoshi) {
    Array point = hoshi;
    point.transducer.pattern = Pattern::point;
    point.transducer.source_pa_m = 1.0;
    const double k = 2.0 * pi / hoshi.wavelength_m(), r = 0.2;
    const auto fresnel = [&](double x) {
        return hoshi_eq4(x, 0.0, 1.0, 0.01, k, r) / hoshi_eq4(0.0, 0.0, 1.0, 0.01, k, r);
    };
    // First line of eq. 4: equal amplitudes, exact distances.
    const auto equal = [&](double x, bool two) {
        std::complex<double> sum = 0.0;
        for (const Element& e : hoshi.elements)
            sum += std::polar(two ? std::cos(k * e.position.x * 0.02 / r) : 1.0,
                              k * (distance(e, {0, 0, r}) - distance(e, {x, 0, r})));
        return std::abs(sum) / static_cast<double>(hoshi.elements.size());
    };
    const double single = std::abs(pressure(point, ideal_drives(point, {0, 0, r}), {0, 0, r}));
    const std::vector<Focus> foci{{{-0.02, 0, r}}, {{0.02, 0, r}}};
    const auto by = [&](Method method) {
        SolveOptions options;
        options.method = method;
        options.amplitudes = method == Method::inverse_transform;
        return solve(point, foci, options);
    };
    Json found;
    const auto transform = by(Method::inverse_transform), sum = by(Method::superposition), gs = by(Method::gs),
               weighted = by(Method::weighted_gs);
    for (int i = -600; i <= 600; ++i) {
        const double x = i * 1e-4;
        found["x_mm"].push_back(x / millimetre);
        found["fresnel"].push_back(std::abs(fresnel(x - 0.02) + fresnel(x + 0.02)) / 2.0);
        found["equal"].push_back(equal(x, true));
        for (const auto& [name, drives] :
             {std::pair("transform", &transform), {"superposition", &sum}, {"gs", &gs}, {"weighted_gs", &weighted}})
            found[name].push_back(std::abs(pressure(point, *drives, {x, 0, r})) / single);
    }
    const auto one = ideal_drives(point, {0, 0, r});
    for (int i = 0; i <= 520; ++i) {
        const double x = i * 5e-4;
        found["copy_x_mm"].push_back(x / millimetre);
        found["copy_fresnel"].push_back(std::abs(fresnel(x)));
        found["copy_equal"].push_back(equal(x, false));
        found["copy_exact"].push_back(std::abs(pressure(point, one, {x, 0, r})) / single);
    }
    found["repeats_mm"] = hoshi.wavelength_m() * r / 0.01 / millimetre;
    return found;
}

}  // namespace

int main() try {
    const Array tile = find_array("tile-10x10");
    const Array hoshi = find_array("hoshi-18x18");
    const Json found{
        {"formation", formation_over_time(tile)}, {"alternation", alternation(tile)}, {"elevations", elevations(tile)},
        {"hoshi_focus", hoshi_focus(hoshi)},      {"energy_loss", energy_loss()},     {"modulation", modulation(hoshi)},
        {"quantised", quantised_drive(hoshi)},    {"response", frequency_response()}, {"pattern", pattern(hoshi)}};
    fmt::print("{}\n", found.dump());
    return 0;
} catch (const std::exception& error) {
    fmt::print(stderr, "haptogram_figures: {}\n", error.what());
    return 1;
}
