// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/scatterer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"
#include "haptogram/scattering/gmres.hpp"

namespace haptogram::scattering {
namespace {

using Complex = std::complex<double>;

/// @param wave  gives the pressure and its slope along the panel's normal
template <class Wave>
IncidentSound each_panel(const Body& body, Wave wave) {
    IncidentSound sound;
    for (const Panel& panel : body.panels) {
        const auto [pressure, slope] = wave(panel);
        sound.pressure.emplace_back(pressure);
        sound.slope.emplace_back(slope);
    }
    return sound;
}

}  // namespace

IncidentSound incident_from(const Array& array, Drives drives, const Body& body, const FieldOptions& options) {
    std::vector<Vec3> centres;
    for (const Panel& panel : body.panels) centres.push_back(panel.centre);
    IncidentSound sound;
    sound.pressure = pressure_at(array, drives, centres, options);
    const std::vector<PressureGradient> gradients = pressure_gradient_at(array, drives, centres, options);
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const Vec3 n = body.panels[i].normal;
        sound.slope.push_back(gradients[i].x * static_cast<float>(n.x) + gradients[i].y * static_cast<float>(n.y) +
                              gradients[i].z * static_cast<float>(n.z));
    }
    return sound;
}

IncidentSound plane_wave_on(const Body& body, Vec3 direction, double wave_number) {
    const Vec3 k = direction * (wave_number / norm(direction));
    return each_panel(body, [&](const Panel& panel) {
        const Complex p = std::polar(1.0, -dot(k, panel.centre));
        return std::pair(p, Complex(0.0, -dot(k, panel.normal)) * p);
    });
}

IncidentSound point_source_on(const Body& body, Vec3 source, double wave_number) {
    return each_panel(body, [&](const Panel& panel) {
        const Vec3 away = panel.centre - source;
        const double r = norm(away);
        const Complex p = std::polar(1.0 / r, -wave_number * r);
        return std::pair(p, -p * Complex(1.0 / r, wave_number) * (dot(away, panel.normal) / r));
    });
}

namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

}  // namespace

Complex scattered_at(const Body& body, std::span<const std::complex<float>> pressure, double wave_number, Vec3 point) {
    Complex sum;
    for (std::size_t i = 0; i < body.panels.size(); ++i) {
        const Panel& panel = body.panels[i];
        const Vec3 from = point - panel.centre;
        const double r = norm(from);
        sum += Complex(pressure[i]) * std::polar(panel.area / (4.0 * pi * r), -wave_number * r) *
               Complex(1.0 / r, wave_number) * (dot(from, panel.normal) / r);
    }
    return sum;
}

Complex scattered_far(const Body& body, std::span<const std::complex<float>> pressure, double wave_number,
                      Vec3 direction) {
    Complex sum;
    for (std::size_t i = 0; i < body.panels.size(); ++i) {
        const Panel& panel = body.panels[i];
        sum += Complex(pressure[i]) * std::polar(panel.area / (4.0 * pi), wave_number * dot(direction, panel.centre)) *
               Complex(0.0, wave_number * dot(direction, panel.normal));
    }
    return sum;
}

namespace {

constexpr std::size_t most_panels = 16000;  ///< a matrix of 2 GB
constexpr std::size_t sounds_at_once = 16;  ///< as many searches go in step

}  // namespace

Scatterer::Scatterer(const Body& body, double wave_number, const ScatteringOptions& options)
    : options_(options), kernel_{wave_number, options.coupling / wave_number} {
    if (body.panels.size() > most_panels)
        throw bad_input(body.name,
                        fmt::format("has {} triangles; at most {} can be computed. Give a smaller body, or a "
                                    "coarser mesh",
                                    body.panels.size(), most_panels));
    matrix_ = boundary_matrix(body, kernel_);
}

void Scatterer::factorise() {
    if (factors_) return;
    factors_.emplace(matrix_);
    DenseMatrix ones(matrix_.rows, 1), again(matrix_.rows, 1);
    std::fill(ones.values.begin(), ones.values.end(), 1.0F);
    factors_->solve(ones);
    multiply(matrix_, ones, again);
    double square = 0.0;
    for (const std::complex<float> one : again.values) square += static_cast<double>(std::norm(one - 1.0F));
    factors_residual_ = std::sqrt(square / static_cast<double>(matrix_.rows));
    matrix_.values = {};  // as large as the factors, and not needed any more
}

std::size_t Scatterer::worth_factorising() const { return std::max<std::size_t>(2, matrix_.rows / 50); }

SurfacePressures Scatterer::pressures(std::span<const IncidentSound> sounds) const {
    SurfacePressures found;
    found.residual = factors_residual_;
    const auto beta = std::complex<float>(0.0F, static_cast<float>(-kernel_.coupling_m));
    for (std::size_t first = 0; first < sounds.size(); first += sounds_at_once) {
        const auto part = sounds.subspan(first, std::min(sounds_at_once, sounds.size() - first));
        DenseMatrix sides(matrix_.rows, part.size());
        for (std::size_t s = 0; s < part.size(); ++s)
            for (std::size_t i = 0; i < matrix_.rows; ++i)
                sides.column(s)[i] = part[s].pressure[i] + beta * part[s].slope[i];
        DenseMatrix solutions;
        if (factors_) {
            solutions = sides;
            factors_->solve(solutions);
        } else {
            Iterated iterated = gmres(matrix_, sides, options_.tolerance, options_.most_rounds);
            found.rounds = std::max(found.rounds, iterated.rounds);
            found.residual = std::max(found.residual, iterated.residual);
            solutions = std::move(iterated.solutions);
        }
        for (std::size_t s = 0; s < part.size(); ++s)
            found.pressure.emplace_back(solutions.column(s), solutions.column(s) + matrix_.rows);
    }
    return found;
}

}  // namespace haptogram::scattering
