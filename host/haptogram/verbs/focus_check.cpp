// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/focus_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/format/emission.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/solve/drives.hpp"
#include "haptogram/solve/segments.hpp"

namespace haptogram {

std::vector<std::complex<double>> exact_drives(const Array& array, std::span<const Focus> foci, Method solver) {
    if (foci.size() == 1) return ideal_drives(array, foci.front().position);
    SolveOptions options;
    options.method = solver;
    std::vector<std::complex<double>> drives = solve(array, foci, options);
    for (std::complex<double>& drive : drives)
        if (drive != 0.0) drive *= array.transducer.source_pa_m / std::abs(drive);
    return drives;
}

std::vector<std::complex<double>> asked_drives(const Manifest& manifest, const RecordMeaning& record) {
    const double full = std::sin(std::numbers::pi * manifest.timer.duty());
    std::vector<std::complex<double>> drives = manifest.foci
                                                   ? summed_drives(manifest.array, record.foci)
                                                   : exact_drives(manifest.array, record.foci, manifest.solver);
    if (manifest.foci)
        for (std::size_t m = 0; m < drives.size(); ++m) drives[m] *= std::abs(manifest.array.elements[m].aligning());
    const double scale = manifest.foci ? manifest.array.transducer.source_pa_m / manifest.foci->full : 1.0;
    for (std::complex<double>& drive : drives) drive *= full * record.amplitude * scale;
    return drives;
}

namespace {

/// The length of every drive as the pulse that the board makes of it: whole ticks.
void round_to_pulses(std::vector<std::complex<double>>& drives, const Manifest& manifest) {
    const double source = manifest.array.transducer.source_pa_m;
    for (std::complex<double>& drive : drives) {
        const double amplitude = std::min(1.0, std::abs(drive) / source);
        if (amplitude == 0.0) continue;
        const std::uint32_t ticks =
            emission_ticks(static_cast<std::uint16_t>(std::lround(65535.0 * amplitude)), manifest.timer.cycle_ticks,
                           manifest.core.parameters.min_pulse_clocks);
        drive *= std::sin(std::numbers::pi * ticks / manifest.timer.cycle_ticks) / amplitude;
    }
}

}  // namespace

Vec3 lateral_peak(const Array& array, std::span<const std::complex<double>> drives, Vec3 start) {
    constexpr double first_step = 0.5e-3;
    constexpr double last_step = 0.5e-6;
    Vec3 best = start;
    double highest = std::abs(pressure(array, drives, best));
    for (double step = first_step; step > last_step;) {
        const std::array<Vec3, 4> around = {best + Vec3{step, 0, 0}, best - Vec3{step, 0, 0}, best + Vec3{0, step, 0},
                                            best - Vec3{0, step, 0}};
        bool climbed = false;
        for (const Vec3& candidate : around) {
            const double here = std::abs(pressure(array, drives, candidate));
            if (here > highest) {
                highest = here;
                best = candidate;
                climbed = true;
            }
        }
        if (!climbed) step /= 2.0;
    }
    return best;
}

FocusCheck check_focus(const Array& array, std::span<const std::complex<double>> drives,
                       std::span<const std::complex<double>> reference, Vec3 focus) {
    FocusCheck check;
    check.pressure_pa = std::abs(pressure(array, drives, focus));
    check.pressure_kept = check.pressure_pa / std::abs(pressure(array, reference, focus));
    // From the same peak on: beside a stronger focus, a weak one may have none of its own.
    const Vec3 asked = lateral_peak(array, reference, focus);
    check.peak_offset_m = distance(lateral_peak(array, drives, asked), asked);
    return check;
}

namespace {

/// The second derivative, downwards, of the pressure at a peak across the axis, in the direction in which it is least.
double least_curvature(const Array& array, std::span<const std::complex<double>> drives, Vec3 peak) {
    constexpr double step = 0.25e-3;
    const auto at = [&](int x, int y) { return std::abs(pressure(array, drives, peak + Vec3{x * step, y * step, 0})); };
    const double here = at(0, 0), xx = 2 * here - at(1, 0) - at(-1, 0), yy = 2 * here - at(0, 1) - at(0, -1);
    const double xy = (at(1, -1) + at(-1, 1) - at(1, 1) - at(-1, -1)) / 4;
    return ((xx + yy) / 2 - std::hypot((xx - yy) / 2, xy)) / (step * step);
}

/// Of sums of foci on a board that computes them.
FocusLimits limits_of_sums(const Manifest& manifest, const RecordMeaning& record) {
    constexpr double deviations = 4.0, table_steps = 1024.0, alike = 1e-6;
    FocusLimits limits;
    const Array& array = manifest.array;
    const double tick = std::numbers::pi / manifest.timer.cycle_ticks, source = array.transducer.source_pa_m;
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    const std::vector<std::complex<double>> drives = asked_drives(manifest, record);
    double least = 1.0;
    for (const Focus& focus : record.foci) {
        if (focus.amplitude == 0.0) continue;
        std::complex<double> made = 0.0;
        std::array<double, 2> means{}, squares{};
        double all = 0.0;
        // Elements of the same drive, as symmetric foci have, make the same error: Σ |wave|, and Σ |wave|·|cosine|.
        std::map<std::pair<long, long>, std::array<double, 4>> groups;
        for (std::size_t m = 0; m < drives.size(); ++m) {
            const std::complex<double> wave = propagation(array, array.elements[m], focus.position);
            const std::complex<double> drive = drives[m] / source;
            const Vec3 way = focus.position - array.elements[m].position;
            const double size = std::abs(wave), amplitude = std::min(1.0, std::abs(drive));
            std::array<double, 4>& group =
                groups[{std::lround(drive.real() / alike), std::lround(drive.imag() / alike)}];
            group[0] = tick * tick * (1.0 + 3.0 * amplitude * amplitude) + 1.0 / (table_steps * table_steps);
            group[1] += size;
            made += wave * drive;
            all += size;
            for (const std::size_t axis : {0U, 1U}) {
                const double cosine = (axis == 0 ? way.x : way.y) / norm(way);
                group[2 + axis] += size * std::abs(cosine);
                means[axis] += size * cosine;
                squares[axis] += size * cosine * cosine;
            }
        }
        double pressure = 0.0;
        std::array<double, 2> slopes{};
        for (const auto& [drive, group] : groups) {
            pressure += group[0] / 12.0 * group[1] * group[1];
            for (const std::size_t axis : {0U, 1U}) slopes[axis] += group[0] / 12.0 * group[2 + axis] * group[2 + axis];
        }
        least = std::min(least, 1.0 - deviations * std::sqrt(pressure) / std::abs(made));
        // A weak focus may lie on the slope of a stronger one, whose peak there is flat.
        const double curvature = least_curvature(array, drives, lateral_peak(array, drives, focus.position)) / source;
        if (curvature > 0.0)
            limits.most_offset_m =
                std::max(limits.most_offset_m,
                         FocusLimits{}.most_offset_m +
                             deviations * k * std::hypot(std::sqrt(slopes[0]), std::sqrt(slopes[1])) / curvature);
        for (const std::size_t axis : {0U, 1U}) {
            const double mean = means[axis] / all, spread = squares[axis] / all - mean * mean;
            if (spread > 0.0)
                limits.most_offset_m =
                    std::max(limits.most_offset_m, FocusLimits{}.most_offset_m + deviations * std::sqrt(slopes[axis]) /
                                                                                     (k * spread * std::abs(made)));
        }
    }
    limits.least_kept *= std::max(0.0, least);
    return limits;
}

}  // namespace

FocusLimits limits_of(const Manifest& manifest, const RecordMeaning& record) {
    if (manifest.foci && record.foci.size() > 1) return limits_of_sums(manifest, record);
    FocusLimits limits;
    if (manifest.quantise.empty()) return limits;
    constexpr double deviations = 4.0, alike = 8.0;
    const double largest = std::numbers::pi / segments_of(manifest.quantise).count;
    const auto& elements = manifest.array.elements;
    const double independent = std::max(1.0, static_cast<double>(elements.size()) / alike);
    limits.expected_kept = std::sin(largest) / largest;
    const double deviation = largest * largest / std::sqrt(45.0 * independent);
    limits.least_kept *= limits.expected_kept - deviations * deviation;
    double farthest = 0.0;
    for (const Focus& focus : record.foci)
        for (const bool along_x : {true, false}) {
            if (focus.amplitude == 0.0) continue;
            double sum = 0.0, squares = 0.0;
            for (const Element& element : elements) {
                const Vec3 way = focus.position - element.position;
                const double cosine = (along_x ? way.x : way.y) / norm(way);
                sum += cosine;
                squares += cosine * cosine;
            }
            const double spread = squares - sum * sum / static_cast<double>(elements.size());
            const double k = 2.0 * std::numbers::pi / manifest.array.wavelength_m();
            // A row of elements across the axis cannot move the peak along it.
            if (spread > 0.0) farthest = std::max(farthest, largest / std::sqrt(3.0 * spread) / k);
        }
    limits.most_offset_m += deviations * farthest;
    return limits;
}

FocusCheck check_record(const Manifest& manifest, const RecordMeaning& record,
                        std::span<const std::complex<double>> drives) {
    // The length of the pulses is what the timer can make, and no error of the phases. So both sides of the comparison
    // have the same length. Of several foci computed by the board, each channel has a length of its own, and what is
    // rounded on one is made up for by others.
    std::vector<std::complex<double>> reference;
    if (manifest.foci) {
        reference = asked_drives(manifest, record);
        if (record.foci.size() == 1) round_to_pulses(reference, manifest);
    } else {
        const double duty =
            static_cast<double>(pulse_ticks(manifest.timer, record.amplitude)) / manifest.timer.cycle_ticks;
        reference = exact_drives(manifest.array, record.foci, manifest.solver);
        for (std::complex<double>& drive : reference) drive *= std::sin(std::numbers::pi * duty);
    }
    // The lengths of modulated pulses are those of the samples in whose periods they were measured, one channel's in
    // others than its neighbour's; only the phases are the record's.
    std::vector<std::complex<double>> measured(drives.begin(), drives.end());
    if (manifest.modulation)
        for (std::size_t m = 0; m < measured.size(); ++m)
            if (measured[m] != 0.0) measured[m] *= std::abs(reference[m]) / std::abs(measured[m]);
    FocusCheck worst{0.0, std::numeric_limits<double>::infinity(), 0.0};
    for (const Focus& focus : record.foci) {
        if (focus.amplitude == 0.0) continue;  // held down, and no peak
        const FocusCheck one = check_focus(manifest.array, measured, reference, focus.position);
        if (one.pressure_kept < worst.pressure_kept) {
            worst.pressure_pa = one.pressure_pa;
            worst.pressure_kept = one.pressure_kept;
        }
        worst.peak_offset_m = std::max(worst.peak_offset_m, one.peak_offset_m);
    }
    return worst;
}

}  // namespace haptogram
