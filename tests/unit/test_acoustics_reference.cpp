// SPDX-License-Identifier: Apache-2.0
// The library's field against what can be had without it: Rayleigh's integral, closed forms, and symmetries.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "haptogram/acoustics/propagation.hpp"

using namespace haptogram;
using std::numbers::pi;

namespace {

using Complex = std::complex<double>;

constexpr double speed = 343.2;
constexpr double k = 2.0 * pi * 40e3 / speed;
constexpr double radius = 4.5e-3;

/// Rayleigh's integral over a baffled piston, for a source of 1 Pa·m on the axis far away: j/(πa²) ∬ e^{−jks}/s dS.
Complex rayleigh(Vec3 point) {
    constexpr int rings = 150;
    constexpr int spokes = 60;
    Complex sum = 0.0;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < spokes; ++j) {
            const double r = radius * (i + 0.5) / rings;
            const double turn = 2.0 * pi * (j + 0.5) / spokes;
            const double s = std::hypot(point.x - r * std::cos(turn), point.y - r * std::sin(turn), point.z);
            sum += std::polar(r / s, -k * s);
        }
    return Complex(0.0, 1.0) * sum * (radius / rings) * (2.0 * pi / spokes) / (pi * radius * radius);
}

Vec3 at(double range, double angle_deg) {
    const double angle = angle_deg * pi / 180.0;
    return {range * std::sin(angle) * 0.6, range * std::sin(angle) * 0.8, range * std::cos(angle)};
}

}  // namespace

TEST_CASE("reference: Rayleigh's integral on the piston's axis is the closed form", "[reference]") {
    // |p| = 2ρcU·|sin(k/2·(√(z² + a²) − z))|, and ρcU = 2/(ka²) for a source of 1 Pa·m.
    for (const double z : {0.002, 0.005, 0.02, 0.1, 0.4}) {
        const double expected = 4.0 / (k * radius * radius) * std::abs(std::sin(k / 2.0 * (std::hypot(z, radius) - z)));
        REQUIRE(std::abs(rayleigh({0, 0, z})) == Approx(expected).epsilon(2e-5));
    }
}

TEST_CASE("reference: the far-field piston against Rayleigh's integral", "[reference]") {
    // The largest error of the amplitude up to 60° from the axis, over the amplitude there: it falls with 1/R².
    const auto [range, amplitude, phase] =
        GENERATE(table<double, double, double>({{0.05, 4e-3, 0.08}, {0.1, 1e-3, 0.04}, {0.3, 1.5e-4, 0.013}}));
    for (int i = 0; i <= 24; ++i) {
        const double angle = 2.5 * i;
        const Complex exact = rayleigh(at(range, angle));
        const Complex found = piston_wave({}, at(range, angle), k, radius);
        CAPTURE(range, angle);
        REQUIRE(std::abs(found) == Approx(std::abs(exact)).epsilon(amplitude));
        // A baffled source of real velocity leads the monopole of 1 Pa·m by a quarter turn.
        REQUIRE(std::abs(std::arg(Complex(0, 1) * found / exact)) < phase);
    }
}

TEST_CASE("reference: a focused spherical cap on its axis, O'Neil's closed form", "[reference]") {
    constexpr double curvature = 0.1;
    constexpr double aperture = 0.04;
    constexpr int count = 20000;
    const double height = curvature - std::sqrt(curvature * curvature - aperture * aperture);
    const double area = 2.0 * pi * curvature * height;
    Array cap;
    cap.medium.speed_m_s = speed;
    cap.transducer.pattern = Pattern::point;
    for (int i = 0; i < count; ++i) {  // equal areas, turned by the golden angle
        const double z = height * (i + 0.5) / count;
        const double r = std::sqrt(z * (2.0 * curvature - z));
        const double turn = i * pi * (3.0 - std::sqrt(5.0));
        cap.elements.push_back({r * std::cos(turn), r * std::sin(turn), z});
    }
    // Each a piece of a surface that moves with ρcU = 1 Pa.
    const std::vector<Complex> drives(count, Complex(0, k * area / count / (2.0 * pi)));
    for (const double z : {0.05, 0.07, 0.09, 0.0999, 0.11, 0.15}) {
        const double rim = std::hypot(z - height, aperture);
        const Complex oneil = (std::polar(1.0, -k * z) - std::polar(1.0, -k * rim)) / (1.0 - z / curvature);
        REQUIRE(std::abs(pressure(cap, drives, {0, 0, z}) - oneil) < 1e-3 * std::abs(oneil));
    }
    // At the focus: ρcU·kh; beside it 2J1(x)/x, x = ka·ρ/A (O'Neil's approximation, good to 1 % of the peak here).
    REQUIRE(std::abs(pressure(cap, drives, {0, 0, curvature})) == Approx(k * height).epsilon(1e-6));
    for (const double x : {0.5e-3, 2e-3, 4e-3, 8e-3})
        REQUIRE(std::abs(pressure(cap, drives, {x, 0, curvature})) / (k * height) ==
                Approx(std::abs(piston_directivity(k * aperture * x / curvature))).margin(0.01));
}

TEST_CASE("reference: translation, rotation, reflection, scale and reciprocity", "[reference]") {
    const auto seed = Catch::rngSeed();
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto draw = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
    Array array = find_array(GENERATE("tile-10x10", "hoshi-18x18"));
    array.elements.resize(37);
    array.medium.absorption_np_m = 0.2;
    std::vector<Complex> drives;
    for (const Element& element : array.elements) {
        (void)element;
        drives.push_back(std::polar(draw(0.0, 3.0), draw(-pi, pi)));
    }
    for (int i = 0; i < 20; ++i) {
        const Vec3 point{draw(-0.1, 0.1), draw(-0.1, 0.1), draw(0.02, 0.3)};
        const Complex p = pressure(array, drives, point);
        // Of the sum's largest possible value, for points where little is left of it.
        double most = 0.0;
        for (std::size_t m = 0; m < drives.size(); ++m)
            most += std::abs(drives[m]) / distance(array.elements[m], point);
        const auto same = [&](const Array& other, Vec3 where, double factor) {
            REQUIRE(std::abs(factor * pressure(other, drives, where) - p) < 1e-10 * most);
        };
        Array other = array;
        const Vec3 shift{draw(-1, 1), draw(-1, 1), draw(-1, 1)};
        for (Element& e : other.elements) e.position = e.position + shift;
        same(other, point + shift, 1.0);

        const double turn = draw(-pi, pi);
        const auto turned = [&](Vec3 v) {
            return Vec3{v.x * std::cos(turn) - v.y * std::sin(turn), v.x * std::sin(turn) + v.y * std::cos(turn), v.z};
        };
        other = array;
        for (Element& e : other.elements) e.position = turned(e.position);
        same(other, turned(point), 1.0);

        other = array;
        for (Element& e : other.elements) e.position.x = -e.position.x;
        same(other, {-point.x, point.y, point.z}, 1.0);

        // All lengths, the wavelength, the radius and the absorption's length too: pressure goes with 1/length.
        const double scale = draw(0.2, 5.0);
        other = array;
        for (Element& e : other.elements) e.position = scale * e.position;
        other.carrier_hz /= scale;
        other.transducer.radius_m *= scale;
        other.medium.absorption_np_m /= scale;
        same(other, scale * point, scale);

        // Source and receiver change places, for patterns that are the same in front and behind.
        other = array;
        other.transducer.pattern = i % 2 == 0 ? Pattern::point : Pattern::piston;
        REQUIRE(propagation(other, other.elements[0], point) ==
                propagation(other, {point}, other.elements[0].position));
    }
}
