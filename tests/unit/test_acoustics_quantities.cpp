// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/base/error.hpp"

using namespace haptogram;
using std::numbers::pi;

namespace {

using Complex = std::complex<double>;

/// Hoshi eq. 4: the field of N × N sources at a focal length r in the Fresnel approximation, amplitude p each.
Complex hoshi_field(double x, double y, double p, int n, double pitch, double k, double r) {
    const auto array_factor = [&](double u) {
        const double half = k * pitch * u / r / 2.0;
        return std::abs(half) < 1e-9 ? n : std::sin(n * half) / std::sin(half);
    };
    return p * array_factor(x) * array_factor(y);
}

}  // namespace

TEST_CASE("quantities: level and radiation pressure of Hoshi's transducer", "[quantities]") {
    const Medium air{340.0, 1.2, 0.0};
    const double one = 24.0 * std::numbers::sqrt2;
    REQUIRE(sound_level_db(one) == Approx(121.58).margin(0.005));  // Hoshi: 121.5 dB
    REQUIRE(sound_level_db({0.0, one}) == sound_level_db(one));
    REQUIRE(sound_level_db(20e-6 * std::numbers::sqrt2) == Approx(0.0).margin(1e-12));
    REQUIRE(std::isinf(sound_level_db(0.0)));
    REQUIRE(radiation_pressure(one, air) == Approx(8.3e-3).margin(0.05e-3));
    REQUIRE(radiation_pressure(100.0 * one, air) == Approx(83.0).margin(0.1));
    REQUIRE(radiation_pressure(one, air, skin_reflection) / radiation_pressure(one, air) == Approx(0.9995));
    // Skin on air, eq. 2: R = 0.9995, R² = 0.999, α = 1.999.
    REQUIRE(std::sqrt(reflected_energy(1.63e6, 0.0004e6)) == Approx(0.9995).margin(5e-5));
    REQUIRE(1.0 + reflected_energy(1.63e6, 0.0004e6) == Approx(skin_reflection).margin(5e-5));
}

TEST_CASE("quantities: Hoshi's focus: 18.9 mm, 42 mm, 0.048, 143 mN", "[quantities]") {
    const Medium air{340.0, 1.2, 0.0};
    const double wavelength = 340.0 / 40e3;
    const double k = 2.0 * pi / wavelength;
    const double diameter = focal_diameter(wavelength, 0.2, 0.18);
    REQUIRE(diameter == Approx(18.9e-3).margin(0.05e-3));
    REQUIRE(focal_depth(wavelength, 0.2, 0.18) == Approx(42e-3).margin(0.05e-3));
    const double p = 36.0 * std::numbers::sqrt2;
    const auto field = [&](Vec3 at) { return hoshi_field(at.x, at.y, p, 18, 10e-3, k, 0.2); };
    REQUIRE(std::abs(field({diameter / 2.0, 0, 0})) < 1e-9 * std::abs(field({})));  // the main lobe's zero
    double lobe = 0.0;
    for (int i = 0; i < 2000; ++i) lobe = std::max(lobe, std::norm(field({diameter * (0.5 + i / 2000.0), 0, 0})));
    REQUIRE(lobe / std::norm(field({})) == Approx(0.048).margin(0.0005));
    const double force = force_through_square(field, air, {}, diameter, wavelength / 2.0);
    REQUIRE(force == Approx(143e-3).margin(0.5e-3));
    // Finer panels, and a sum over many small cells, change nothing.
    REQUIRE(force_through_square(field, air, {}, diameter, wavelength / 16.0) == Approx(force).epsilon(1e-6));
    constexpr int cells = 400;
    const double cell = diameter / cells;
    double sum = 0.0;
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j)
            sum += std::norm(field({(i + 0.5) * cell - diameter / 2, (j + 0.5) * cell - diameter / 2, 0})) / 2.0 *
                   cell * cell * 2.0 / (1.2 * 340.0 * 340.0);
    REQUIRE(force == Approx(sum).epsilon(1e-4));
    // The same array as the sum of its waves, without Fresnel's approximation, here and in the library.
    Array array = find_array("hoshi-18x18");
    array.transducer.pattern = Pattern::point;
    array.transducer.source_pa_m = p * 0.2;
    const Vec3 focus = from_mm(0, 0, 200);
    const double summed = force_through_square(array, ideal_drives(array, focus), focus, diameter);
    constexpr int coarse = 60;
    const double width = diameter / coarse;
    double expected = 0.0;
    for (int i = 0; i < coarse; ++i)
        for (int j = 0; j < coarse; ++j) {
            Complex wave = 0.0;
            for (int m = 0; m < 324; ++m) {
                const int row = m / 18;
                const double ex = (m % 18 - 8.5) * 10e-3;
                const double ey = (row - 8.5) * 10e-3;
                const double to_focus = std::sqrt(ex * ex + ey * ey + 0.04);
                const double x = (i + 0.5) * width - diameter / 2 - ex;
                const double y = (j + 0.5) * width - diameter / 2 - ey;
                const double here = std::sqrt(x * x + y * y + 0.04);
                wave += std::polar(p * 0.2 / here, k * (to_focus - here));
            }
            expected += std::norm(wave) / (1.2 * 340.0 * 340.0) * width * width;
        }
    REQUIRE(summed == Approx(expected).epsilon(1e-3));
    REQUIRE(summed == Approx(force).epsilon(0.06));  // 150 mN: the focus is wider than eq. 4 has it
}

TEST_CASE("quantities: the gradient is that of the pressure, and velocity obeys Euler's equation", "[quantities]") {
    Array array = find_array("tile-10x10");
    array.elements.resize(23);
    array.medium.absorption_np_m = 0.15;
    const int kind = GENERATE(0, 1, 2);
    if (kind == 1) array.transducer.pattern = Pattern::point;
    if (kind == 2) {
        array.transducer.pattern = Pattern::table;
        array.transducer.table = find_transducer("T4010A1").table;
    }
    const auto drives = ideal_drives(array, from_mm(10, -5, 90));
    const auto p = [&](Vec3 at) { return pressure(array, drives, at); };
    constexpr double h = 1e-6;
    const double omega = 2.0 * pi * array.carrier_hz;
    for (const Vec3 at : {from_mm(10.1, -5.2, 90), from_mm(-37, 21, 44), from_mm(3.3, 80, 15)}) {
        const ComplexVec3 slope = pressure_gradient(array, drives, at);
        const ComplexVec3 v = particle_velocity(array, drives, at);
        const double scale = std::abs(slope.x) + std::abs(slope.y) + std::abs(slope.z);
        const auto check = [&](Vec3 step, Complex along, Complex speed) {
            // Fourth-order differences: off by (kh)⁴/30.
            const Complex difference =
                (8.0 * (p(at + step) - p(at - step)) - (p(at + 2.0 * step) - p(at - 2.0 * step))) / (12.0 * h);
            REQUIRE(std::abs(along - difference) < 1e-6 * scale);
            // ρ ∂v/∂t = −∇p with ∂/∂t = jω.
            REQUIRE(std::abs(array.medium.density_kg_m3 * Complex(0, omega) * speed + difference) < 1e-6 * scale);
        };
        check({h, 0, 0}, slope.x, v.x);
        check({0, h, 0}, slope.y, v.y);
        check({0, 0, h}, slope.z, v.z);
    }
}

TEST_CASE("quantities: far from one source the impedance is that of a plane wave", "[quantities]") {
    Array array = find_array("tile-10x10");
    array.elements = {Element{}};
    const std::vector<Complex> drives = {2.0};
    const Vec3 at = from_mm(0, 0, 2000);
    const ComplexVec3 v = particle_velocity(array, drives, at);
    const double rho_c = array.medium.density_kg_m3 * array.medium.speed_m_s;
    const double k = 2.0 * pi / array.wavelength_m();
    REQUIRE(std::abs(v.x) == 0.0);
    // v = p/(ρc)·(1 + 1/(jkR)): the sound goes away from the source, and near it the air lags.
    const Complex expected = pressure(array, drives, at) / rho_c * (1.0 + 1.0 / Complex(0, k * 2.0));
    REQUIRE(std::abs(v.z - expected) < 1e-12 * std::abs(expected));
    REQUIRE(intensity(array, drives, at).z == Approx(1.0 / (2.0 * rho_c)).epsilon(1e-9));  // |p| = 1 Pa
    REQUIRE_THROWS_AS(particle_velocity(array, drives, {}), Error);
}

TEST_CASE("quantities: the power of an array of monopoles, through planes, a hemisphere and on paper", "[quantities]") {
    // A smooth beam, so that planes of finite size catch it: half-wavelength pitch, Gaussian drives.
    Array array;
    array.transducer.pattern = Pattern::point;
    const double pitch = array.wavelength_m() / 2.0;
    std::vector<Complex> drives;
    for (int i = -7; i <= 7; ++i)
        for (int j = -7; j <= 7; ++j) {
            array.elements.push_back({i * pitch, j * pitch, 0.0});
            drives.push_back(std::exp(-(i * i + j * j) * pitch * pitch / (13e-3 * 13e-3)));
        }
    // On paper: pairs of monopoles radiate A·A'·sinc(kd)·2π/(ρc) each into all directions, half of it upwards.
    const double k = 2.0 * pi / array.wavelength_m();
    const double rho_c = array.medium.density_kg_m3 * array.medium.speed_m_s;
    double paper = 0.0;
    for (std::size_t a = 0; a < drives.size(); ++a)
        for (std::size_t b = 0; b < drives.size(); ++b) {
            const double kd = k * distance(array.elements[a], array.elements[b].position);
            paper += std::real(drives[a] * std::conj(drives[b])) * (kd == 0.0 ? 1.0 : std::sin(kd) / kd) * pi / rho_c;
        }
    const auto through_plane = [&](double z, double half, int cells) {
        const double cell = 2.0 * half / cells;
        double power = 0.0;
        for (int i = 0; i < cells; ++i)
            for (int j = 0; j < cells; ++j)
                power +=
                    intensity(array, drives, {(i + 0.5) * cell - half, (j + 0.5) * cell - half, z}).z * cell * cell;
        return power;
    };
    const double near = through_plane(0.05, 0.1, 80);
    const double middle = through_plane(0.1, 0.15, 75);
    const double far = through_plane(0.2, 0.2, 80);
    constexpr double radius = 0.3;
    constexpr int rings = 240;
    constexpr int spokes = 24;
    double hemisphere = 0.0;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < spokes; ++j) {
            const double polar = pi / 2 * (i + 0.5) / rings;
            const double turn = 2 * pi * (j + 0.5) / spokes;
            const Vec3 n{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
            hemisphere += dot(intensity(array, drives, radius * n), n) * radius * radius * std::sin(polar) *
                          (pi / 2 / rings) * (2 * pi / spokes);
        }
    CAPTURE(near / paper, middle / paper, far / paper, hemisphere / paper);
    REQUIRE(near == Approx(paper).epsilon(1e-3));
    REQUIRE(middle == Approx(paper).epsilon(1e-3));
    REQUIRE(far == Approx(paper).epsilon(1e-3));
    REQUIRE(hemisphere == Approx(paper).epsilon(1e-3));
    // With absorption the beam loses e^{−2αz}.
    array.medium.absorption_np_m = 0.5;
    REQUIRE(through_plane(0.2, 0.2, 80) / through_plane(0.1, 0.15, 75) ==
            Approx(std::exp(-2 * 0.5 * 0.1)).epsilon(0.01));
}
