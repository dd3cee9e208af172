// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/magnitude.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::perception {
namespace {

/// Rounding must not put the ends of a range outside of it.
constexpr double ends_gf = 1e-12;

double cubic(const std::array<double, 4>& p, double x) { return ((p[0] * x + p[1]) * x + p[2]) * x + p[3]; }
double parabola(const std::array<double, 3>& p, double x) { return (p[0] * x + p[1]) * x + p[2]; }

/// The x of a rising function with f(x) = y, by bisection to the last bit.
template <class Function>
double inverse(const Function& rising, double y, double low, double high) {
    for (int i = 0; i < 200 && low < high; ++i) {
        const double middle = low + (high - low) / 2.0;
        if (middle == low || middle == high) break;
        (rising(middle) < y ? low : high) = middle;
    }
    return std::abs(rising(low) - y) < std::abs(rising(high) - y) ? low : high;
}

void require_output(const FrequencyFit& fit, double gf) {
    const double most = full_output_gf(fit);
    if (!(gf >= 0.0 && gf <= most + ends_gf))
        throw bad_argument("output",
                           fmt::format("{:.5g} gf lies outside of 0…{:.5g} gf, which were measured at {:g} Hz; ask for "
                                       "an output in that range",
                                       gf, most, fit.frequency_hz));
}

}  // namespace

FrequencyFit fit_at(const Tables& tables, double frequency_hz) {
    const auto& fits = tables.fits;
    if (!(frequency_hz >= fits.front().frequency_hz && frequency_hz <= fits.back().frequency_hz))
        throw bad_argument("frequency",
                           fmt::format("{:g} Hz lies outside of {:g}…{:g} Hz, which {} covers; ask for a "
                                       "frequency in that range",
                                       frequency_hz, fits.front().frequency_hz, fits.back().frequency_hz, tables.name));
    const auto above = std::find_if(fits.begin(), fits.end(),
                                    [&](const FrequencyFit& fit) { return fit.frequency_hz >= frequency_hz; });
    if (above->frequency_hz == frequency_hz) return *above;
    const FrequencyFit& a = *(above - 1);
    const FrequencyFit& b = *above;
    // Both polynomials are linear in their coefficients, so these are interpolated instead of their values.
    const double weight = std::log(frequency_hz / a.frequency_hz) / std::log(b.frequency_hz / a.frequency_hz);
    FrequencyFit fit{
        frequency_hz, {}, {}, std::min(a.command_r2, b.command_r2), std::min(a.magnitude_r2, b.magnitude_r2)};
    for (std::size_t i = 0; i < fit.command.size(); ++i) fit.command[i] = std::lerp(a.command[i], b.command[i], weight);
    for (std::size_t i = 0; i < fit.magnitude.size(); ++i)
        fit.magnitude[i] = std::lerp(a.magnitude[i], b.magnitude[i], weight);
    return fit;
}

double full_output_gf(const FrequencyFit& fit) {
    double high = 1.0;
    while (cubic(fit.command, high) < 1.0 && high < 1e6) high *= 2.0;
    return inverse([&](double g) { return cubic(fit.command, g); }, 1.0, 0.0, high);
}

double command_of_output(const FrequencyFit& fit, double gf) {
    require_output(fit, gf);
    return cubic(fit.command, gf);
}

double output_of_command(const FrequencyFit& fit, double command) {
    const double least = fit.command.back();
    if (!(command >= least && command <= 1.0))
        throw bad_argument("command", fmt::format("{:.5g} lies outside of {:.4f}…1: below, the fit at {:g} Hz has no "
                                                  "output, and 1 is the full command",
                                                  command, least, fit.frequency_hz));
    return inverse([&](double g) { return cubic(fit.command, g); }, command, 0.0, full_output_gf(fit));
}

double magnitude_of_output(const FrequencyFit& fit, double gf) {
    require_output(fit, gf);
    return parabola(fit.magnitude, gf);
}

double output_of_magnitude(const FrequencyFit& fit, double magnitude) {
    const double full = full_output_gf(fit);
    const double least = parabola(fit.magnitude, 0.0), most = parabola(fit.magnitude, full);
    if (!(magnitude >= least && magnitude <= most))
        throw bad_argument("magnitude",
                           fmt::format("{:.5g} cannot be made at {:g} Hz, where {:.4g}…{:.4g} can; ask for "
                                       "a magnitude in that range, or a lower frequency",
                                       magnitude, fit.frequency_hz, least, most));
    return inverse([&](double g) { return parabola(fit.magnitude, g); }, magnitude, 0.0, full);
}

}  // namespace haptogram::perception
