// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "haptogram/acoustics/region.hpp"
#include "haptogram/array/array.hpp"

namespace haptogram {

/// A short cut for a grid of points whose steps divide the pitch of an array that is itself a grid.
///
/// Relative to each element, the points then lie on one common lattice, only shifted by whole steps. The fields of all
/// elements are therefore shifted copies of one field, which needs computing only once.
struct ShiftedGrid {
    std::vector<double> x, y;  ///< coordinates of the lattice, relative to the element
    std::vector<std::size_t>
        rows;  ///< for each row of the lattice, which y has its field; rows at y and −y have the same
    std::size_t step_columns = 0, step_rows = 0;  ///< lattice steps in one pitch of the array
    std::size_t last_column = 0, last_row = 0;    ///< of the array

    /// The lattice's column that holds the grid's first column, relative to the elements in the array's column `of`.
    [[nodiscard]] std::size_t column(std::size_t of) const { return (last_column - of) * step_columns; }
};

/// Finds the lattice. Nothing when there is none to within a nanometre, or when an element does not face +z.
[[nodiscard]] std::optional<ShiftedGrid> find_shifts(const Array& array, const Grid& grid);

}  // namespace haptogram
