// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/slice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "haptogram/base/error.hpp"
#include "haptogram/verbs/focus_analysis.hpp"

namespace haptogram {
namespace {

void require_few_terms(std::size_t points, std::size_t elements, std::size_t sets) {
    const double terms = static_cast<double>(points) * static_cast<double>(elements) * static_cast<double>(sets);
    if (terms > most_slice_terms)
        throw bad_argument("slice", fmt::format("{} points of {} elements with {} sets of drives are too many; take "
                                                "fewer points",
                                                points, elements, sets));
}

void require_sound(const Slice& slice, std::size_t elements, std::size_t sets) {
    if (std::min(slice.width, slice.height) < 2 || std::max(slice.width, slice.height) > most_slice_points)
        throw bad_argument("slice", fmt::format("has {} × {} points; take 2 to {} along each edge", slice.width,
                                                slice.height, most_slice_points));
    for (const Vec3& each : {slice.origin, slice.u, slice.v})
        if (!std::isfinite(each.x) || !std::isfinite(each.y) || !std::isfinite(each.z))
            throw bad_argument("slice", "its corner and its edges must be finite numbers");
    require_few_terms(slice.size(), elements, sets);
}

std::vector<double> spread(double from, double length, std::uint32_t count) {
    std::vector<double> found;
    for (std::uint32_t i = 0; i < count; ++i) found.push_back(from + length * i / (count - 1));
    return found;
}

/// The axis that an edge lies along, 0 to 2; none for other directions.
std::optional<int> axis_of(Vec3 edge) {
    if (edge.y == 0.0 && edge.z == 0.0) return 0;
    if (edge.x == 0.0 && edge.z == 0.0) return 1;
    if (edge.x == 0.0 && edge.y == 0.0) return 2;
    return {};
}

/// The same points as a grid, which has x fastest and z slowest; none when the slice has another order or lies askew.
std::optional<Grid> grid_of(const Slice& slice) {
    const auto along_u = axis_of(slice.u), along_v = axis_of(slice.v);
    if (!along_u || !along_v || *along_u >= *along_v) return {};
    Grid grid{{slice.origin.x}, {slice.origin.y}, {slice.origin.z}};
    if (*along_u == 0) grid.x = spread(slice.origin.x, slice.u.x, slice.width);
    if (*along_u == 1) grid.y = spread(slice.origin.y, slice.u.y, slice.width);
    if (*along_v == 1) grid.y = spread(slice.origin.y, slice.v.y, slice.height);
    if (*along_v == 2) grid.z = spread(slice.origin.z, slice.v.z, slice.height);
    return grid;
}

std::vector<Vec3> points_of(const Slice& slice) {
    std::vector<Vec3> points;
    points.reserve(slice.size());
    for (std::uint32_t j = 0; j < slice.height; ++j)
        for (std::uint32_t i = 0; i < slice.width; ++i)
            points.push_back(slice.origin + (static_cast<double>(i) / (slice.width - 1)) * slice.u +
                             (static_cast<double>(j) / (slice.height - 1)) * slice.v);
    return points;
}

}  // namespace

std::vector<float> mean_square_on(const Excitation& excitation, const Slice& slice, unsigned threads,
                                  const Progress& progress) {
    require_sound(slice, excitation.array.elements.size(), excitation.drives.size());
    const FieldOptions options{threads, progress};
    if (const std::optional<Grid> grid = grid_of(slice))
        return mean_square_pressure(excitation.array, excitation.sequence(), *grid, options);
    return mean_square_pressure_at(excitation.array, excitation.sequence(), points_of(slice), options);
}

std::vector<float> mean_square_at(const Excitation& excitation, std::span<const Vec3> points) {
    if (points.empty() || points.size() > most_skin_points)
        throw bad_argument("points", fmt::format("found {}, expected 1 to {}", points.size(), most_skin_points));
    require_few_terms(points.size(), excitation.array.elements.size(), excitation.drives.size());
    return mean_square_pressure_at(excitation.array, excitation.sequence(), points);
}

std::vector<float> reachable_on(const Array& array, const Slice& slice) {
    require_sound(slice, array.elements.size(), 1);
    std::vector<float> found;
    found.reserve(slice.size());
    for (const Vec3& point : points_of(slice)) {
        const double amplitude_pa = reachable_pressure(array, point);
        found.push_back(std::isnan(amplitude_pa) ? 0.0F : static_cast<float>(0.5 * amplitude_pa * amplitude_pa));
    }
    return found;
}

}  // namespace haptogram
