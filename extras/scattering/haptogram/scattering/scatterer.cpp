// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/scatterer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/scattering/gmres.hpp"

namespace haptogram::scattering {
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
