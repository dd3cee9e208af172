// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/shift.hpp"

#include <algorithm>
#include <cmath>

namespace haptogram {
namespace {

constexpr double tolerance_m = 1e-9;

/// Whether the coordinates are evenly spaced by `step`.
bool even(const std::vector<double>& axis, double step) {
    for (std::size_t i = 0; i < axis.size(); ++i)
        if (!(std::abs(axis[i] - axis.front() - static_cast<double>(i) * step) <= tolerance_m)) return false;
    return true;
}

struct Steps {
    double step = 0.0;        ///< metres
    std::size_t a_pitch = 0;  ///< steps in one pitch
};

/// The step of a grid's axis, and how many steps make one pitch of the array; nothing when no whole number does.
std::optional<Steps> find_steps(const std::vector<double>& axis, const std::vector<double>& elements) {
    const double spread = elements.back() - elements.front();
    const double pitch = elements.size() > 1 ? spread / static_cast<double>(elements.size() - 1) : 0.0;
    if (pitch < 0.0 || !even(elements, pitch)) return {};
    if (axis.size() == 1) return Steps{pitch, 1};
    const double step = (axis.back() - axis.front()) / static_cast<double>(axis.size() - 1);
    if (!(step > tolerance_m) || !even(axis, step)) return {};
    const double ratio = std::round(pitch / step);
    // A small difference between pitch and steps adds up over the array; at its far end it must still be small.
    const double drift = std::abs(pitch - ratio * step) * static_cast<double>(elements.size() - 1);
    if (ratio > 1e6 || (elements.size() > 1 && ratio < 1.0) || drift > tolerance_m) return {};
    return Steps{step, std::max<std::size_t>(1, static_cast<std::size_t>(ratio))};
}

/// The lattice's coordinates along one axis. It begins with the grid's first point relative to the last element, and
/// ends with the grid's last point relative to the first element.
std::vector<double> lattice(const std::vector<double>& axis, const std::vector<double>& elements, Steps steps) {
    const std::size_t before = (elements.size() - 1) * steps.a_pitch;
    std::vector<double> found(axis.size() + before);
    for (std::size_t i = 0; i < found.size(); ++i)
        found[i] =
            axis.front() - elements.front() + (static_cast<double>(i) - static_cast<double>(before)) * steps.step;
    return found;
}

}  // namespace

std::optional<ShiftedGrid> find_shifts(const Array& array, const Grid& grid) {
    if (array.columns == 0 || array.elements.empty() || grid.size() == 0) return {};
    const std::size_t columns = std::min<std::size_t>(array.columns, array.elements.size());
    std::vector<double> of_columns, of_rows;
    for (std::size_t m = 0; m < columns; ++m) of_columns.push_back(array.elements[m].position.x);
    for (std::size_t m = 0; m < array.elements.size(); m += array.columns)
        of_rows.push_back(array.elements[m].position.y);
    for (std::size_t m = 0; m < array.elements.size(); ++m) {
        const Vec3 on_grid{of_columns[m % array.columns], of_rows[m / array.columns], array.elements[0].position.z};
        if (!(distance(array.elements[m], on_grid) <= tolerance_m)) return {};
        if (array.elements[m].normal != Vec3{0.0, 0.0, 1.0}) return {};
    }
    const auto x = find_steps(grid.x, of_columns);
    const auto y = find_steps(grid.y, of_rows);
    if (!x || !y) return {};

    ShiftedGrid found;
    found.x = lattice(grid.x, of_columns, *x);
    found.step_columns = x->a_pitch;
    found.step_rows = y->a_pitch;
    found.last_column = of_columns.size() - 1;
    found.last_row = of_rows.size() - 1;
    const std::vector<double> rows = lattice(grid.y, of_rows, *y);
    const double mirrored = rows.front() / (y->step > 0.0 ? y->step : 1.0) *
                            -2.0;  // row i at y has its mirror image, −y, in row mirrored − i
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const double other = std::round(mirrored) - static_cast<double>(i);
        const auto mirror = static_cast<std::size_t>(std::max(0.0, other));
        if (other >= 0.0 && mirror < i && std::abs(rows[mirror] + rows[i]) <= tolerance_m) {
            found.rows.push_back(found.rows[mirror]);
        } else {
            found.rows.push_back(found.y.size());
            found.y.push_back(rows[i]);
        }
    }
    return found;
}

}  // namespace haptogram
