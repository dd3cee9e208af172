// SPDX-License-Identifier: Apache-2.0
// In place of dense.cpp in a build without OpenBLAS (HAPTOGRAM_OPENBLAS=OFF).
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/scattering/dense.hpp"

namespace haptogram::scattering {
namespace {

using Stride = Eigen::OuterStride<>;
using Values = Eigen::Map<Eigen::MatrixXcf, 0, Stride>;

Eigen::Index whole(std::size_t value) { return static_cast<Eigen::Index>(value); }

Values map(DenseMatrix& m) { return {m.values.data(), whole(m.rows), whole(m.columns), Stride(whole(m.stride))}; }
Eigen::Map<const Eigen::MatrixXcf, 0, Stride> map(const DenseMatrix& m) {
    return {m.values.data(), whole(m.rows), whole(m.columns), Stride(whole(m.stride))};
}

}  // namespace

void multiply(const DenseMatrix& matrix, const DenseMatrix& factor, DenseMatrix& product) {
    map(product).noalias() = map(matrix) * map(factor);
}

Factors::Factors(DenseMatrix matrix) : factors_(std::move(matrix)), pivots_(factors_.rows) {
    Values values = map(factors_);
    const Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXcf>> lu(values);  // in place
    for (Eigen::Index row = 0; row < values.rows(); ++row)
        if (values(row, row) == 0.0F)
            throw Error(ErrorCode::failed, "scattering", fmt::format("the matrix is singular in row {}", row + 1));
    std::ranges::copy(lu.permutationP().indices(), pivots_.begin());
}

void Factors::solve(DenseMatrix& sides) const {
    const auto lu = map(factors_);
    const Eigen::Map<const Eigen::VectorXi> places(pivots_.data(), lu.rows());
    Values values = map(sides);
    Eigen::MatrixXcf x = places.asPermutation() * values;
    lu.triangularView<Eigen::UnitLower>().solveInPlace(x);
    lu.triangularView<Eigen::Upper>().solveInPlace(x);
    values = x;
}

}  // namespace haptogram::scattering
