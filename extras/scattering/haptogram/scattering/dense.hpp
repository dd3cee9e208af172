// SPDX-License-Identifier: Apache-2.0
// Dense complex matrices in single precision, by BLAS and LAPACK on one thread.
#pragma once
#include <complex>
#include <cstddef>
#include <vector>

namespace haptogram::scattering {

/// Stored column by column, each column padded to `stride` values.
struct DenseMatrix {
    std::size_t rows = 0, columns = 0, stride = 0;
    std::vector<std::complex<float>> values;

    DenseMatrix() = default;
    DenseMatrix(std::size_t row_count, std::size_t column_count, std::size_t column_stride)
        : rows(row_count), columns(column_count), stride(column_stride), values(column_stride * column_count) {}
    DenseMatrix(std::size_t row_count, std::size_t column_count) : DenseMatrix(row_count, column_count, row_count) {}

    [[nodiscard]] std::complex<float>* column(std::size_t c) { return values.data() + c * stride; }
    [[nodiscard]] const std::complex<float>* column(std::size_t c) const { return values.data() + c * stride; }
};

/// product = matrix · factor; all have their sizes already.
void multiply(const DenseMatrix& matrix, const DenseMatrix& factor, DenseMatrix& product);

/// A square matrix taken apart, so that systems with it can be solved in the time of a product.
class Factors {
public:
    /// @throws Error{failed} when the matrix is singular
    explicit Factors(DenseMatrix matrix);
    /// Puts the solutions in the place of the right-hand sides.
    void solve(DenseMatrix& sides) const;

private:
    DenseMatrix factors_;
    std::vector<int> pivots_;
};

}  // namespace haptogram::scattering
