// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/propagation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "haptogram/base/error.hpp"

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

namespace {

double wave_number(const Array& array) { return 2.0 * std::numbers::pi / array.wavelength_m(); }

}  // namespace

double piston_directivity(double ka_sin) {
    const double x = std::abs(ka_sin);
    if (x < 1e-4) return 1.0 - x * x / 8.0;  // the first terms of its series; the quotient would be 0/0
    return 2.0 * std::cyl_bessel_j(1.0, x) / x;
}

Error coincidence() {
    return bad_input("field", "a point coincides with an element, where the pressure is infinite; move it");
}

std::complex<double> piston_wave(const Element& element, Vec3 point, double k, double radius_m) {
    const Vec3 ray = point - element.position;
    const double range = norm(ray);
    if (range == 0.0) throw coincidence();
    const double sine = norm(cross(ray, element.normal)) / range;
    return std::polar(piston_directivity(k * radius_m * sine) / range, -k * range);
}

double directivity(const Transducer& transducer, double k, double cosine) {
    if (transducer.pattern == Pattern::point) return 1.0;
    if (transducer.pattern == Pattern::piston)
        return piston_directivity(k * transducer.radius_m * std::sqrt(std::max(0.0, 1.0 - cosine * cosine)));
    if (cosine < 0.0) return 0.0;
    const double last = static_cast<double>(transducer.table.size() - 1);
    const double place = std::acos(std::min(cosine, 1.0)) / (std::numbers::pi / 2.0) * last;
    const double low = std::min(std::floor(place), last - 1.0);
    const auto at = static_cast<std::size_t>(low);
    return std::lerp(transducer.table[at], transducer.table[at + 1], place - low);
}

std::complex<double> propagation(const Array& array, const Element& element, Vec3 point) {
    const Vec3 ray = point - element.position;
    const double range = norm(ray);
    if (range == 0.0) throw coincidence();
    const double k = wave_number(array);
    const double cosine = dot(ray, element.normal) / range;
    return element.response * std::polar(directivity(array.transducer, k, cosine) / range *
                                             std::exp(-array.medium.absorption_np_m * range),
                                         -k * range);
}

std::vector<std::complex<double>> propagation_matrix(const Array& array, std::span<const Vec3> points) {
    std::vector<std::complex<double>> matrix;
    matrix.reserve(points.size() * array.elements.size());
    for (const Vec3& point : points)
        for (const Element& element : array.elements) matrix.push_back(propagation(array, element, point));
    return matrix;
}

std::vector<std::complex<double>> ideal_drives(const Array& array, Vec3 focus) {
    const double k = wave_number(array);
    std::vector<std::complex<double>> drives;
    drives.reserve(array.elements.size());
    for (const Element& element : array.elements)
        drives.push_back(element.aligning() * std::polar(array.transducer.source_pa_m, k * distance(element, focus)));
    return drives;
}

double focal_width(const Array& array, Vec3 focus) {
    const auto drives = ideal_drives(array, focus);
    const double half = 0.5 * std::norm(pressure(array, drives, focus));
    const auto reaches = [&](double side) {
        const auto above = [&](double away) {
            return std::norm(pressure(array, drives, focus + Vec3{side * away, 0.0, 0.0})) > half;
        };
        double inside = 0.0, outside = 1e-3;
        while (above(outside)) inside = std::exchange(outside, outside + 1e-3);
        for (int i = 0; i < 12; ++i) {
            const double middle = 0.5 * (inside + outside);
            (above(middle) ? inside : outside) = middle;
        }
        return 0.5 * (inside + outside);
    };
    return reaches(1.0) + reaches(-1.0);
}

std::complex<double> pressure(const Array& array, std::span<const std::complex<double>> drives, Vec3 point) {
    std::complex<double> sum = 0.0;
    for (std::size_t m = 0; m < array.elements.size(); ++m)
        sum += drives[m] * propagation(array, array.elements[m], point);
    return sum;
}

}  // namespace haptogram
