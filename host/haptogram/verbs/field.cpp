// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/field.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/focus_analysis.hpp"

namespace haptogram {
namespace {

/// Rms particle velocity, m/s, by Euler's equation: |∇p|/(ωρ√2).
/// @param array  as the grid's own coordinates have it
std::vector<float> rms_velocity(const Array& array, const Excitation& excitation, const Grid& grid,
                                const FieldOptions& options) {
    double total = 0.0;
    for (const double weight : excitation.weights) total += weight;
    std::vector<Vec3> points;
    points.reserve(grid.size());
    for (std::size_t i = 0; i < grid.size(); ++i) points.push_back(grid.point(i));
    std::vector<double> square(points.size());
    const auto records = static_cast<double>(excitation.drives.size());
    for (std::size_t r = 0; r < excitation.drives.size(); ++r) {
        FieldOptions part = options;
        part.progress =
            options.progress.between(static_cast<double>(r) / records, static_cast<double>(r + 1) / records);
        const auto slopes = pressure_gradient_at(array, excitation.drives[r], points, part);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double here = static_cast<double>(std::norm(slopes[i].x)) +
                                static_cast<double>(std::norm(slopes[i].y)) +
                                static_cast<double>(std::norm(slopes[i].z));
            square[i] += excitation.weights[r] / total * here / 2.0;
        }
    }
    const double per_slope = 1.0 / (2.0 * std::numbers::pi * array.carrier_hz * array.medium.density_kg_m3);
    std::vector<float> found;
    found.reserve(points.size());
    for (const double one : square) found.push_back(static_cast<float>(per_slope * std::sqrt(one)));
    return found;
}

}  // namespace

Quantity quantity_of(std::string_view name) {
    std::string known;
    for (const QuantityName& one : quantity_names) {
        if (one.name == name) return one.quantity;
        known += fmt::format("{}{}", known.empty() ? "" : ", ", one.name);
    }
    throw bad_argument("quantity", fmt::format("must be one of {}, found '{}'", known, name));
}

Field field(const Excitation& excitation, const Region& region, Quantity quantity, unsigned threads,
            const Progress& progress) {
    Field found{region, {}, {}, {}, excitation.foci, excitation.title, FieldMethod::sums, 0.0, quantity};
    const Array array = region.pose ? seen_from(excitation.array, *region.pose) : excitation.array;
    FieldOptions options;
    options.threads = threads == 0 ? std::max(1U, std::thread::hardware_concurrency()) : threads;
    options.progress = progress;
    if (quantity == Quantity::complex) {
        if (excitation.drives.size() != 1)
            throw bad_argument("quantity",
                               fmt::format("complex is of one set of phases, and this plays {}; choose one record",
                                           excitation.drives.size()),
                               {"record"});
        found.quantity = "pressure_pa";
        found.parts.resize(2);
        found.names = {"real", "imag"};
        const PressureField pressure = pressure_field(array, excitation.drives.front(), region.grid, options);
        found.method = pressure.method;
        found.error = pressure.error;
        for (const std::complex<float> value : pressure.values) {
            found.parts[0].push_back(value.real());
            found.parts[1].push_back(value.imag());
        }
        return found;
    }
    if (quantity == Quantity::velocity) {
        found.quantity = "rms_velocity_m_s";
        found.label = "rms particle velocity / (m/s)";
        found.parts = {rms_velocity(array, excitation, region.grid, options)};
        found.error = gradient_error;
        return found;
    }
    MeanSquareField mean = mean_square_field(array, excitation.sequence(), region.grid, options);
    found.method = mean.method;
    found.error = mean.error;
    found.parts = {std::move(mean.values)};
    const Medium& medium = array.medium;
    const auto each = [&](const char* name, const char* label, auto make) {
        found.quantity = name;
        found.label = label;
        for (float& value : found.parts.front()) value = static_cast<float>(make(static_cast<double>(value)));
    };
    if (quantity == Quantity::radiation)
        each("radiation_pressure_pa", "time-averaged radiation pressure / Pa",
             [&](double square) { return radiation_pressure(std::sqrt(2.0 * square), medium); });
    else if (quantity == Quantity::rms)
        each("rms_pressure_pa", "rms sound pressure / Pa", [](double square) { return std::sqrt(square); });
    else
        each("spl_db", "sound pressure level / dB re 20 µPa",
             [](double square) { return sound_level_db(std::sqrt(2.0 * square)); });
    return found;
}

Field workspace_field(const Array& array, const Region& region) {
    return {region,
            "reachable_pressure_pa",
            "pressure amplitude that a focus can have / Pa",
            {workspace(array, region.grid)},
            {},
            array.name + ", focused on each point",
            FieldMethod::sums,
            0.0};
}

}  // namespace haptogram
