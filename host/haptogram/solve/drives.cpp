// SPDX-License-Identifier: Apache-2.0
#include "haptogram/solve/drives.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/solve/focal_law.hpp"

namespace haptogram {
namespace {

Record empty_record(const Timer& timer, std::uint32_t channels, double amplitude) {
    return {timer.cycle_ticks, timer.prescaler, static_cast<std::uint8_t>(pulse_ticks(timer, amplitude)),
            std::vector<std::uint16_t>(channels, interface::silent_timing)};
}

}  // namespace

std::vector<std::complex<double>> superposed_drives(const Array& array, std::span<const Focus> foci) {
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    std::vector<std::complex<double>> drives(array.elements.size());
    double wanted = 0.0;
    for (const Focus& focus : foci) {
        if (!is_finite(focus.position))
            throw bad_input("superposition", "a focal point is not finite; every coordinate must be a number");
        double farthest = 0.0;
        for (const Element& element : array.elements)
            farthest = std::max(farthest, distance(element.position, focus.position));
        for (std::size_t m = 0; m < drives.size(); ++m) {
            const double behind = farthest - distance(array.elements[m].position, focus.position);
            drives[m] += std::polar(focus.amplitude, -k * behind);
        }
        wanted = std::max(wanted, focus.amplitude);
    }
    double strongest = 0.0;
    for (const std::complex<double>& drive : drives) strongest = std::max(strongest, std::abs(drive));
    if (strongest > 0.0)
        for (std::size_t m = 0; m < drives.size(); ++m)
            drives[m] *= array.elements[m].aligning() * (wanted / strongest);
    return drives;
}

Record quantise(std::span<const std::complex<double>> drives, const Timer& timer, std::uint32_t channels) {
    double strongest = 0.0;
    for (const std::complex<double>& drive : drives) strongest = std::max(strongest, std::abs(drive));
    Record record = empty_record(timer, channels, strongest);
    for (std::size_t m = 0; m < drives.size(); ++m) {
        if (drives[m] == 0.0) continue;
        const double turns = -std::arg(drives[m]) / (2.0 * std::numbers::pi);
        const auto tick = std::lround((turns - std::floor(turns)) * timer.cycle_ticks);
        record.timings[m] = static_cast<std::uint16_t>(tick == timer.cycle_ticks ? 0 : tick);
    }
    return record;
}

std::vector<Record> records_of(const Array& array, const Timer& timer, std::uint32_t channels,
                               std::span<const PathStep> steps, std::span<const double> amplitudes, Method method) {
    array.require_one_weight();
    SolveOptions options;
    options.method = method;
    const std::size_t elements = array.elements.size();
    std::vector<Vec3> single;
    for (const PathStep& step : steps)
        if (step.foci.size() == 1) single.push_back(step.foci.front().position);
    const std::vector<std::uint16_t> ticks = focal_law(array, timer, single);
    std::vector<Record> records;
    std::size_t next = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        double largest = 0.0;
        for (const Focus& focus : steps[i].foci) largest = std::max(largest, focus.amplitude);
        if (steps[i].foci.size() == 1) {
            Record record = empty_record(timer, channels, largest * amplitudes[i]);
            std::copy_n(ticks.begin() + static_cast<std::ptrdiff_t>(next++ * elements), elements,
                        record.timings.begin());
            records.push_back(std::move(record));
        } else {
            Record record = quantise(solve(array, steps[i].foci, options), timer, channels);
            record.pulse_length = static_cast<std::uint8_t>(pulse_ticks(timer, largest * amplitudes[i]));
            records.push_back(std::move(record));
        }
    }
    return records;
}

}  // namespace haptogram
