// SPDX-License-Identifier: Apache-2.0
#include "haptogram/analysis/focus_check.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"

namespace haptogram {

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

FocusCheck check_focus(const Array& array, std::span<const std::complex<double>> drives, Vec3 focus) {
    const auto ideal = ideal_drives(array, focus);
    // The duty that the timer can make is the image's choice, not an error of its phases: compare at the same one.
    const double duty_amplitude = std::sin(std::numbers::pi * array.duty);
    FocusCheck check;
    check.pressure_pa = std::abs(pressure(array, drives, focus));
    check.pressure_kept = check.pressure_pa / (duty_amplitude * std::abs(pressure(array, ideal, focus)));
    check.peak_offset_m = distance(lateral_peak(array, drives, focus), lateral_peak(array, ideal, focus));
    return check;
}

}  // namespace haptogram
