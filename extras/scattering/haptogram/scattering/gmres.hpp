// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

#include "haptogram/scattering/dense.hpp"

namespace haptogram::scattering {

struct Iterated {
    DenseMatrix solutions;   ///< one column a right-hand side
    std::size_t rounds = 0;  ///< products with the matrix
    double residual = 0.0;   ///< the largest of all sides, over the side's own length
};

/// Solves matrix · x = side for several right-hand sides by GMRES without restarts (Saad and Schultz 1986). Each side
/// has a search of its own; they go in step, so that the matrix is read once a round for all.
/// @param tolerance  of the residual over the side's length
/// @throws Error{failed} when `most_rounds` are not enough
[[nodiscard]] Iterated gmres(const DenseMatrix& matrix, const DenseMatrix& sides, double tolerance,
                             std::size_t most_rounds);

}  // namespace haptogram::scattering
