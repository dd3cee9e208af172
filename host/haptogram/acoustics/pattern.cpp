// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/pattern.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "haptogram/acoustics/propagation.hpp"

namespace haptogram {
namespace {

/// The first coefficients of the Chebyshev series of a directivity in t = 2·cos²θ − 1, found from its values at `nodes`
/// angles.
/// @param at  directivity against the angle, radians
template <class At>
std::vector<double> chebyshev_series(int nodes, int count, At at) {
    std::vector<double> values(static_cast<std::size_t>(nodes)), series(static_cast<std::size_t>(count));
    for (int i = 0; i < nodes; ++i)  // cos 2θ = t
        values[static_cast<std::size_t>(i)] = at(std::numbers::pi * (i + 0.5) / nodes / 2.0);
    std::vector<double> cosines(static_cast<std::size_t>(4 * nodes));  // of all angles that the sums below need
    for (int i = 0; i < 4 * nodes; ++i)
        cosines[static_cast<std::size_t>(i)] = std::cos(std::numbers::pi * i / (2.0 * nodes));
    for (int j = 0; j < count; ++j) {
        double sum = 0.0;
        for (int i = 0; i < nodes; ++i)
            sum +=
                values[static_cast<std::size_t>(i)] * cosines[static_cast<std::size_t>(j * (2 * i + 1) % (4 * nodes))];
        series[static_cast<std::size_t>(j)] = sum * (j == 0 ? 1.0 : 2.0) / nodes;
    }
    return series;
}

/// A Chebyshev series, cut off after `degree`, as coefficients of the powers of t.
std::vector<double> powers(const std::vector<double>& series, std::size_t degree) {
    std::vector<double> sum(degree + 1), before(degree + 1), current(degree + 1);
    before[0] = 1.0;  // T₀ = 1 and T₁ = t; the others follow by Tₙ₊₁ = 2t·Tₙ − Tₙ₋₁
    current[1] = 1.0;
    sum[0] = series[0];
    for (std::size_t n = 1; n <= degree; ++n) {
        for (std::size_t i = 0; i <= degree; ++i) sum[i] += series[n] * current[i];
        std::vector<double> next(degree + 1);
        for (std::size_t i = 0; i <= degree; ++i) next[i] = (i == 0 ? 0.0 : 2.0 * current[i - 1]) - before[i];
        before = std::exchange(current, next);
    }
    return sum;
}

/// The polynomial of the lowest degree that is good enough, if there is one.
std::optional<std::vector<double>> piston_polynomial(double ka) {
    const auto series =
        chebyshev_series(48, 48, [&](double angle) { return piston_directivity(ka * std::sin(angle)); });
    for (const std::size_t degree : polynomial_degrees) {
        double rest = 0.0, size = 0.0;
        for (std::size_t n = degree + 1; n < series.size(); ++n) rest += std::abs(series[n]);
        std::vector<double> found = powers(series, degree);
        for (const double c : found) size += std::abs(c);
        if (rest <= 1e-6 && size <= 16.0) return found;  // large coefficients would cancel and lose digits
    }
    return {};
}

/// A table of a piston's directivity. Straight lines between its entries are off by at most 1e-6, because the second
/// derivative against the angle is at most about (ka)²/4.
std::vector<float> piston_table(double ka) {
    const double steps = std::clamp(std::ceil(ka * std::numbers::pi / 2.0 / std::sqrt(32e-6)), 1e3, 1e6);
    std::vector<float> table(static_cast<std::size_t>(steps) + 1);
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = static_cast<float>(
            piston_directivity(ka * std::sin(std::numbers::pi / 2.0 * static_cast<double>(i) / steps)));
    return table;
}

/// The polynomial of the lowest degree, 5 or 8, that differs from a measured table by at most `most`, if there is one.
/// The differences are largest near the table's angles, where its straight lines meet.
std::optional<FittedPattern> measured_polynomial(const Transducer& transducer, double most) {
    const auto at = [&](double angle) { return directivity(transducer, 0.0, std::cos(angle)); };
    const auto series = chebyshev_series(512, 9, at);
    for (const std::size_t degree : {polynomial_degrees[0], polynomial_degrees[1]}) {
        const std::vector<double> found = powers(series, degree);
        double error = 0.0;
        const std::size_t steps = 32 * (transducer.table.size() - 1);
        for (std::size_t i = 0; i <= steps; ++i) {
            const double angle = std::numbers::pi / 2.0 * static_cast<double>(i) / static_cast<double>(steps);
            double sum = 0.0;
            for (std::size_t n = degree + 1; n-- > 0;) sum = sum * std::cos(2.0 * angle) + found[n];
            error = std::max(error, std::abs(sum - at(angle)));
        }
        if (error <= most)
            return FittedPattern{FittedPattern::Kind::polynomial, {found.begin(), found.end()}, false, error};
    }
    return {};
}

}  // namespace

FittedPattern fit_pattern(const Transducer& transducer, double k, double measured_error) {
    using Kind = FittedPattern::Kind;
    const double ka = k * transducer.radius_m;
    if (transducer.pattern == Pattern::point || (transducer.pattern == Pattern::piston && ka == 0.0)) return {};
    if (transducer.pattern == Pattern::table) {
        if (measured_error > 0.0)
            if (auto polynomial = measured_polynomial(transducer, measured_error)) return *polynomial;
        return {Kind::table, {transducer.table.begin(), transducer.table.end()}, false, 0.0};
    }
    if (const auto polynomial = piston_polynomial(ka))
        return {Kind::polynomial, {polynomial->begin(), polynomial->end()}, true, 0.0};
    return {Kind::table, piston_table(ka), true, 0.0};
}

}  // namespace haptogram
