// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "haptogram/acoustics/grid.hpp"
#include "haptogram/model/array.hpp"

namespace haptogram {

/// A grid whose steps divide the pitch of an array that is itself a grid: every element sees the same lattice of
/// points, shifted by whole steps, so that one element's field is enough.
struct ShiftedGrid {
    std::vector<double> x, y;                     ///< of the lattice, from the element
    std::vector<std::size_t> rows;                ///< which y stands for each lattice row: those of ±y are one
    std::size_t step_columns = 0, step_rows = 0;  ///< lattice points a pitch
    std::size_t last_column = 0, last_row = 0;    ///< of the array

    /// Where the lattice holds the grid's first column as the array's column `of` sees it.
    [[nodiscard]] std::size_t column(std::size_t of) const { return (last_column - of) * step_columns; }
};

/// The grid's shifts, if array and grid have them to within a nanometre.
[[nodiscard]] std::optional<ShiftedGrid> find_shifts(const Array& array, const Grid& grid);

}  // namespace haptogram
