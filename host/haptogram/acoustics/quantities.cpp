// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/quantities.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"

namespace haptogram {
namespace {

/// dD/dθ, the slope of directivity() against the angle.
double directivity_slope(const Transducer& transducer, double k, double cosine, double sine) {
    if (transducer.pattern == Pattern::point) return 0.0;
    if (transducer.pattern == Pattern::piston) {
        // d/dx 2·J1(x)/x = −2·J2(x)/x, which is −x/4 near the axis.
        const double ka = k * transducer.radius_m;
        const double x = ka * sine;
        const double slope = x < 1e-4 ? -x / 4.0 : -2.0 * std::cyl_bessel_j(2.0, x) / x;
        return slope * ka * cosine;
    }
    if (cosine < 0.0) return 0.0;
    const double last = static_cast<double>(transducer.table.size() - 1);
    const double per_radian = last / (std::numbers::pi / 2.0);
    const double place = std::atan2(sine, cosine) * per_radian;
    const auto at = static_cast<std::size_t>(std::min(std::floor(place), last - 1.0));
    return (transducer.table[at + 1] - transducer.table[at]) * per_radian;
}

}  // namespace

double reflected_energy(double impedance_1, double impedance_2) {
    const double r = (impedance_2 - impedance_1) / (impedance_2 + impedance_1);
    return r * r;
}

double sound_level_db(std::complex<double> pressure) {
    constexpr double reference_pa = 20e-6;
    return 20.0 * std::log10(std::abs(pressure) / std::numbers::sqrt2 / reference_pa);
}

double radiation_pressure(std::complex<double> pressure, const Medium& medium, double alpha) {
    return alpha * std::norm(pressure) / 2.0 / (medium.density_kg_m3 * medium.speed_m_s * medium.speed_m_s);
}

double focal_diameter(double wavelength_m, double focal_length_m, double side_m) {
    return 2.0 * wavelength_m * focal_length_m / side_m;
}

double focal_depth(double wavelength_m, double focal_length_m, double side_m) {
    return 2.0 * focal_length_m * focal_diameter(wavelength_m, focal_length_m, side_m) / side_m;
}

double force_through_square(const std::function<std::complex<double>(Vec3)>& pressure, const Medium& medium,
                            Vec3 centre, double side_m, double panel_m, double alpha) {
    // Gauss-Legendre on [−1, 1]: x² = (5 ∓ 2√(10/7))/9, w = (322 ± 13√70)/900.
    constexpr std::array<double, 5> nodes = {-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
                                             0.906179845938664};
    constexpr std::array<double, 5> weights = {0.236926885056189, 0.478628670499366, 0.568888888888889,
                                               0.478628670499366, 0.236926885056189};
    const auto panels = static_cast<std::size_t>(std::max(1.0, std::ceil(side_m / panel_m)));
    const double half = side_m / static_cast<double>(panels) / 2.0;
    const auto across = [&](std::size_t i) {  // the i-th node's coordinate, from the square's centre
        const std::size_t panel = i / nodes.size();
        return (2.0 * static_cast<double>(panel) + 1.0 + nodes[i % nodes.size()]) * half - side_m / 2.0;
    };
    const std::size_t count = panels * nodes.size();
    double force = 0.0;
    for (std::size_t row = 0; row < count; ++row)
        for (std::size_t column = 0; column < count; ++column) {
            const double weight = weights[row % weights.size()] * weights[column % weights.size()] * half * half;
            const Vec3 point = centre + Vec3{across(column), across(row), 0.0};
            force += weight * radiation_pressure(pressure(point), medium, alpha);
        }
    return force;
}

double force_through_square(const Array& array, std::span<const std::complex<double>> drives, Vec3 centre,
                            double side_m, double alpha) {
    const auto at = [&](Vec3 point) { return pressure(array, drives, point); };
    return force_through_square(at, array.medium, centre, side_m, array.wavelength_m() / 2.0, alpha);
}

ComplexVec3 pressure_gradient(const Array& array, std::span<const std::complex<double>> drives, Vec3 point) {
    const double k = 2.0 * std::numbers::pi / array.wavelength_m();
    const std::complex<double> decay(array.medium.absorption_np_m, k);
    ComplexVec3 sum;
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const Element& element = array.elements[m];
        const Vec3 ray = point - element.position;
        const double range = norm(ray);
        if (range == 0.0) throw coincidence();
        const double height = dot(ray, element.normal);
        const Vec3 aside = ray - height * element.normal;
        const double lateral = norm(aside);
        const double cosine = height / range;
        const std::complex<double> wave = drives[m] * element.response * std::exp(-decay * range) / range;
        // Along the ray, the wave changes by d/dR of e^{−(α+jk)R}/R; across it, by dD/dθ over R.
        const std::complex<double> along =
            -wave * directivity(array.transducer, k, cosine) * (decay + 1.0 / range) / range;
        sum.x += along * ray.x;
        sum.y += along * ray.y;
        sum.z += along * ray.z;
        if (lateral == 0.0) continue;
        const double sine = lateral / range;
        const std::complex<double> across = wave * directivity_slope(array.transducer, k, cosine, sine) / range;
        const Vec3 downwards = (cosine / lateral) * aside - sine * element.normal;  // the direction in which θ grows
        sum.x += across * downwards.x;
        sum.y += across * downwards.y;
        sum.z += across * downwards.z;
    }
    return sum;
}

ComplexVec3 particle_velocity(const Array& array, std::span<const std::complex<double>> drives, Vec3 point) {
    const ComplexVec3 slope = pressure_gradient(array, drives, point);
    const std::complex<double> factor(0.0,
                                      1.0 / (2.0 * std::numbers::pi * array.carrier_hz * array.medium.density_kg_m3));
    return {factor * slope.x, factor * slope.y, factor * slope.z};
}

Vec3 intensity(const Array& array, std::span<const std::complex<double>> drives, Vec3 point) {
    const std::complex<double> p = pressure(array, drives, point) / 2.0;
    const ComplexVec3 v = particle_velocity(array, drives, point);
    return {std::real(p * std::conj(v.x)), std::real(p * std::conj(v.y)), std::real(p * std::conj(v.z))};
}

}  // namespace haptogram
