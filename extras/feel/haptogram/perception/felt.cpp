// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/felt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/perception/magnitude.hpp"
#include "haptogram/perception/waveform.hpp"

namespace haptogram::perception {
namespace {

/// The part at the frequency of modulation over the mean, of the square wave that the tables belong to.
double fundamental_over_mean() { return fundamental_output(Waveform::square) / mean_output(Waveform::square); }

}  // namespace

const char* name_of(Basis basis) {
    switch (basis) {
        case Basis::tables: return "tables";
        case Basis::displacement: return "displacement";
        case Basis::none: return "none";
    }
    return "none";
}

LeastForce least_vibration(const Tables& tables, Region region, double hz, double grip_n) {
    const double first_hz = tables.fits.front().frequency_hz, last_hz = tables.fits.back().frequency_hz;
    const double inside_hz = std::clamp(hz, first_hz, last_hz);
    const double force_n = least_felt_gf(tables, region, inside_hz, grip_n) * gram_force_n * fundamental_over_mean();
    if (hz == inside_hz) return {force_n, Basis::tables};
    if (!(hz >= lowest_vibration_hz && hz <= highest_vibration_hz)) return {};
    const double db = least_displacement_db(hz) - least_displacement_db(inside_hz);
    return {force_n * std::pow(10.0, db / 20.0), Basis::displacement};
}

Felt felt_of(std::span<const Line> spectrum, const Tables& tables, Region region, double grip_n,
             std::size_t most_lines) {
    Felt felt;
    for (const Line& line : spectrum) {
        if (line.hz < lowest_vibration_hz || line.hz > highest_vibration_hz || !(line.amplitude > 0.0)) continue;
        const LeastForce least = least_vibration(tables, region, line.hz, grip_n);
        felt.lines.push_back(
            {line.hz, line.amplitude, least.force_n, 20.0 * std::log10(line.amplitude / least.force_n), least.basis});
    }
    std::stable_sort(felt.lines.begin(), felt.lines.end(),
                     [](const FeltLine& a, const FeltLine& b) { return a.over_db > b.over_db; });
    const auto known = std::find_if(felt.lines.begin(), felt.lines.end(),
                                    [](const FeltLine& line) { return line.basis == Basis::tables; });
    if (region != Region::palm)
        felt.no_magnitude = "magnitudes are known of palms alone";
    else if (known == felt.lines.end())
        felt.no_magnitude = fmt::format("nothing alternates between {:g} and {:g} Hz, which the tables cover",
                                        tables.fits.front().frequency_hz, tables.fits.back().frequency_hz);
    else if (known->over_db < 0.0)
        felt.no_magnitude =
            fmt::format("the strongest line that the tables cover, at {:.4g} Hz, is below the threshold", known->hz);
    else {
        const FrequencyFit fit = fit_at(tables, known->hz);
        const double gf = known->force_n / gram_force_n / fundamental_over_mean();
        if (gf > full_output_gf(fit))
            felt.no_magnitude =
                fmt::format("an output of {:.3f} gf at {:.4g} Hz is more than the {:.3f} gf that the tables end with",
                            gf, known->hz, full_output_gf(fit));
        else
            felt.magnitude = magnitude_of_output(fit, gf);
    }
    felt.lines.resize(std::min(felt.lines.size(), most_lines));
    return felt;
}

}  // namespace haptogram::perception
