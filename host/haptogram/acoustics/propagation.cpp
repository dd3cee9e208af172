// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/propagation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "haptogram/base/error.hpp"

namespace haptogram {
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
