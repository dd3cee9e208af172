// SPDX-License-Identifier: Apache-2.0
// Boundary elements against what does not share their formulas: series for the rigid sphere by Boost.Math, reciprocity,
// and balances of power and momentum between the body's surface and the far field.
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/legendre.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "haptogram/scattering/scatter.hpp"
#include "haptogram/scattering/scatterer.hpp"
#include "haptogram/scattering/shells.hpp"
#include "haptogram/scattering/skin.hpp"

using namespace haptogram;
using namespace haptogram::scattering;

namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double wavelength = 8.58e-3, k = 2.0 * pi / wavelength;
constexpr Complex j{0.0, 1.0};

Complex hankel(int n, double x) {
    const auto order = static_cast<unsigned>(n);
    return {boost::math::sph_bessel(order, x), -boost::math::sph_neumann(order, x)};
}
Complex hankel_slope(int n, double x) {
    return n == 0 ? -hankel(1, x) : hankel(n - 1, x) - (n + 1.0) / x * hankel(n, x);
}

/// Total pressure on a rigid sphere in a plane wave of 1 Pa that travels along +z; cosine of the angle to +z.
Complex plane_wave_series(double ka, double cosine) {
    Complex sum, turn = 1.0;
    for (int n = 0; n < ka + 25; ++n, turn *= -j)
        sum += (2.0 * n + 1.0) * turn * (-j) / (ka * ka * hankel_slope(n, ka)) * boost::math::legendre_p(n, cosine);
    return sum;
}

/// The same of a point source of 1 Pa·m at a distance from the sphere's centre; cosine of the angle to it.
Complex point_source_series(double ka, double distance, double cosine) {
    Complex sum;
    for (int n = 0; n < ka + 20; ++n)
        sum += (2.0 * n + 1.0) * hankel(n, k * distance) / hankel_slope(n, ka) * boost::math::legendre_p(n, cosine);
    return -k / (ka * ka) * sum;
}

Body sphere(double ka, double elements) { return body_of(sphere_mesh(ka / k, wavelength / elements), "sphere"); }

/// A finger that lies obliquely.
Body finger(double elements) {
    const Mesh mesh = capsule_mesh(5e-3, 18e-3, wavelength / elements);
    const Shape placed =
        placed_at(Shape{{mesh}}, {.rotate_deg = {35.0, -20.0, 50.0}, .center = Vec3{1e-3, 2e-3, 3e-3}});
    return body_of(std::get<Mesh>(placed.pieces.front()), "finger");
}

std::vector<std::complex<float>> solve_one(const Body& body, const IncidentSound& sound,
                                           const ScatteringOptions& options = {}) {
    return Scatterer(body, k, options).pressures({&sound, 1}).pressure.front();
}

/// Relative error over the surface, in L2.
template <class Found, class Exact>
double error_of(const Body& body, const Found& found, Exact exact) {
    double apart = 0.0, whole = 0.0;
    for (std::size_t i = 0; i < body.panels.size(); ++i) {
        const auto right = exact(body.panels[i].centre);
        apart += body.panels[i].area * std::norm(Complex(found[i]) - Complex(right));
        whole += body.panels[i].area * std::norm(Complex(right));
    }
    return std::sqrt(apart / whole);
}

double plane_wave_error(double ka, double elements, const ScatteringOptions& options = {}) {
    const Body body = sphere(ka, elements);
    return error_of(body, solve_one(body, plane_wave_on(body, {0, 0, 1}, k), options),
                    [ka](Vec3 p) { return plane_wave_series(ka, p.z / norm(p)); });
}

/// ∫ f dΩ over all directions.
template <class Function>
double over_directions(Function f) {
    using Rule = boost::math::quadrature::gauss<double, 40>;
    return Rule::integrate(
        [&](double z) {
            constexpr int steps = 64;
            double sum = 0.0;
            for (int i = 0; i < steps; ++i) {
                const double angle = 2.0 * pi * i / steps, across = std::sqrt(1.0 - z * z);
                sum += f(Vec3{across * std::cos(angle), across * std::sin(angle), z});
            }
            return sum * 2.0 * pi / steps;
        },
        -1.0, 1.0);
}

}  // namespace

TEST_CASE("scattering: the series of the rigid sphere has its known values", "[scattering]") {
    // |p| over the incoming wave's, computed from the same series by another program.
    REQUIRE(std::abs(plane_wave_series(1, -1)) == Approx(1.4184).margin(5e-5));
    REQUIRE(std::abs(plane_wave_series(5, 0.5)) == Approx(0.8117).margin(5e-5));
    REQUIRE(std::abs(plane_wave_series(5.858, 1)) == Approx(1.1324).margin(5e-5));
    REQUIRE(std::abs(plane_wave_series(10, -1)) == Approx(1.9571).margin(5e-5));
    // A point source far away is a plane wave.
    const double far = 100.0;
    REQUIRE(std::abs(point_source_series(5, far, 0.3)) * far ==
            Approx(std::abs(plane_wave_series(5, -0.3))).epsilon(2e-3));
}

TEST_CASE("scattering: the rigid sphere in a plane wave, eight elements a wavelength", "[scattering]") {
    const auto [ka, most] =
        GENERATE(table<double, double>({{2, 0.02}, {5, 0.01}, {5.763, 0.01}, {5.858, 0.01}, {10, 0.01}}));
    const double error = plane_wave_error(ka, 8);
    CAPTURE(ka, error);
    REQUIRE(error < most);
    REQUIRE(error > mesh_error(8).low);
    REQUIRE(error < mesh_error(8).high);
}

TEST_CASE("scattering: the error falls as is stated with finer meshes", "[scattering]") {
    for (const double elements : {6.0, 12.0, 16.0}) {
        const double ka = elements < 10 ? 10.0 : 3.0, error = plane_wave_error(ka, elements);
        CAPTURE(elements, error);
        REQUIRE(error > mesh_error(elements).low);
        REQUIRE(error < mesh_error(elements).high);
    }
}

TEST_CASE("scattering: without the derivative the equation fails where the inside of the body resonates",
          "[scattering]") {
    // j₂(5.763) = 0. Of the sphere in air nothing happens there.
    REQUIRE(plane_wave_error(5.763, 8, {.coupling = 0.0}) > 0.1);
    REQUIRE(plane_wave_error(5.3, 8, {.coupling = 0.0}) < 0.01);
}

TEST_CASE("scattering: the rigid sphere before a point source", "[scattering]") {
    const double ka = 5, distance = 25e-3;
    const Body body = sphere(ka, 8);
    const Vec3 source = Vec3{2.0, -3.0, 6.0} * (distance / 7.0);
    const auto found = solve_one(body, point_source_on(body, source, k));
    REQUIRE(error_of(body, found, [&](Vec3 p) {
                return point_source_series(ka, distance, dot(p, source) / (norm(p) * distance));
            }) < 0.012);
}

TEST_CASE("scattering: what a source sends by way of a body to a place comes back from there", "[scattering]") {
    const Body body = finger(7);
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    const auto away = [&] {
        Vec3 p;
        do p = {any(random), any(random), any(random)};
        while (norm(p) < 0.2 || norm(p) > 1.0);
        return p * (40e-3 / norm(p));
    };
    const Scatterer scatterer(body, k);
    for (int i = 0; i < 3; ++i) {
        const Vec3 a = away(), b = away();
        const std::vector<IncidentSound> sounds{point_source_on(body, a, k), point_source_on(body, b, k)};
        const auto found = scatterer.pressures(sounds).pressure;
        const Complex there = scattered_at(body, found[0], k, b), back = scattered_at(body, found[1], k, a);
        // In shadows little comes through, so the difference is measured by what a point source makes there.
        REQUIRE(std::abs(there - back) < 0.01 * std::abs(there) + 2e-3 / distance(a, b));
    }
}

TEST_CASE("scattering: power and momentum that leave the body arrive far away", "[scattering]") {
    const bool round = GENERATE(true, false);
    const Body body = round ? sphere(4, 10) : finger(10);
    const Vec3 way = round ? Vec3{0, 0, 1} : Vec3{2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0};
    const IncidentSound sound = plane_wave_on(body, way, k);
    const auto pressure = solve_one(body, sound);
    const Medium medium;
    // Power of the scattered wave at the surface, over that of the incoming wave on a square metre: the surface stands
    // still, so the scattered wave's velocity there is minus the incoming one's, v = −slope/(jωρ).
    double left = 0.0;
    for (std::size_t i = 0; i < body.panels.size(); ++i)
        left += body.panels[i].area *
                std::real(Complex(pressure[i] - sound.pressure[i]) * std::conj(Complex(sound.slope[i]) / (j * k)));
    const auto far = [&](Vec3 direction) { return scattered_far(body, pressure, k, direction); };
    const double arrived = over_directions([&](Vec3 d) { return std::norm(far(d)); });
    REQUIRE(left == Approx(arrived).epsilon(0.01));
    // Optical theorem: what is missing in the wave's own direction.
    REQUIRE(-4.0 * pi / k * std::imag(far(way)) == Approx(arrived).epsilon(0.01));

    // Radiation force along the wave: the momentum that the scattered wave does not carry on.
    const double energy = 1.0 / (2.0 * medium.density_kg_m3 * medium.speed_m_s * medium.speed_m_s);
    const double carried = over_directions([&](Vec3 d) { return dot(d, way) * std::norm(far(d)); });
    const Skin skin(body);
    const auto radiation = skin.radiation_pressure(pressure, k, medium);
    REQUIRE(dot(skin.force(radiation), way) == Approx(energy * (arrived - carried)).epsilon(0.015));
}

TEST_CASE("scattering: radiation pressure on a sphere's skin is that of the series and its slope", "[scattering]") {
    const double ka = 5.858;
    const Body body = sphere(ka, 10);
    const Medium medium;
    const auto found = Skin(body).radiation_pressure(solve_one(body, plane_wave_on(body, {0, 0, 1}, k)), k, medium);
    const double unit = 4.0 * medium.density_kg_m3 * medium.speed_m_s * medium.speed_m_s;
    REQUIRE(error_of(body, found, [&](Vec3 p) {
                const double angle = std::acos(p.z / norm(p)), step = 1e-5;
                const Complex slope =
                    (plane_wave_series(ka, std::cos(angle + step)) - plane_wave_series(ka, std::cos(angle - step))) /
                    (2.0 * step) / ka;
                return (std::norm(plane_wave_series(ka, std::cos(angle))) - std::norm(slope)) / unit;
            }) < 0.02);
}

TEST_CASE("scattering: factors give what the iteration gives, and a still sound nothing", "[scattering]") {
    const Body body = finger(6);
    std::vector<IncidentSound> sounds{plane_wave_on(body, {0, 1, 0}, k), plane_wave_on(body, {0, 1, 0}, k),
                                      point_source_on(body, {0.0, 0.0, 0.05}, k)};
    for (std::complex<float>& p : sounds[1].pressure) p = 0.0F;
    for (std::complex<float>& p : sounds[1].slope) p = 0.0F;
    Scatterer scatterer(body, k);
    const SurfacePressures iterated = scatterer.pressures(sounds);
    REQUIRE((iterated.rounds > 3 && iterated.residual <= 3e-4));
    scatterer.factorise();
    const SurfacePressures direct = scatterer.pressures(sounds);
    REQUIRE((direct.rounds == 0 && direct.residual < 1e-5));
    for (const std::size_t s : {0U, 2U})
        REQUIRE(error_of(body, iterated.pressure[s],
                         [&, i = std::size_t{0}](Vec3) mutable { return direct.pressure[s][i++]; }) < 2e-3);
    for (const auto& p : iterated.pressure[1]) REQUIRE(p == std::complex<float>());
}
