// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/dense.hpp"

#include <fmt/format.h>

#include <utility>

#include "haptogram/base/error.hpp"

// Debian's OpenBLAS brings no header for LAPACK; these are the Fortran routines of both.
extern "C" {
void cgemm_(const char* a_form, const char* b_form, const int* rows, const int* columns, const int* inner,
            const std::complex<float>* alpha, const std::complex<float>* a, const int* a_stride,
            const std::complex<float>* b, const int* b_stride, const std::complex<float>* beta, std::complex<float>* c,
            const int* c_stride);
void cgetrf_(const int* rows, const int* columns, std::complex<float>* a, const int* stride, int* pivots, int* info);
void cgetrs_(const char* form, const int* rows, const int* sides, const std::complex<float>* a, const int* stride,
             const int* pivots, std::complex<float>* b, const int* b_stride, int* info);
int openblas_get_num_threads(void);
void openblas_set_num_threads(int threads);
}

namespace haptogram::scattering {
namespace {

int whole(std::size_t value) { return static_cast<int>(value); }

/// The same bytes, whatever the number of processors. The number of threads is the whole process's, so it is put back:
/// numpy may have the same OpenBLAS.
struct OneThread {
    OneThread() { openblas_set_num_threads(1); }
    ~OneThread() { openblas_set_num_threads(before); }
    OneThread(const OneThread&) = delete;
    OneThread& operator=(const OneThread&) = delete;

    int before = openblas_get_num_threads();
};

}  // namespace

void multiply(const DenseMatrix& matrix, const DenseMatrix& factor, DenseMatrix& product) {
    const OneThread one_thread;
    const int rows = whole(matrix.rows), columns = whole(factor.columns), inner = whole(matrix.columns);
    const int a = whole(matrix.stride), b = whole(factor.stride), c = whole(product.stride);
    const std::complex<float> one(1.0F), zero(0.0F);
    cgemm_("N", "N", &rows, &columns, &inner, &one, matrix.values.data(), &a, factor.values.data(), &b, &zero,
           product.values.data(), &c);
}

Factors::Factors(DenseMatrix matrix) : factors_(std::move(matrix)), pivots_(factors_.rows) {
    const OneThread one_thread;
    const int rows = whole(factors_.rows), stride = whole(factors_.stride);
    int info = 0;
    cgetrf_(&rows, &rows, factors_.values.data(), &stride, pivots_.data(), &info);
    if (info != 0) throw Error(ErrorCode::failed, "scattering", fmt::format("the matrix is singular in row {}", info));
}

void Factors::solve(DenseMatrix& sides) const {
    const OneThread one_thread;
    const int rows = whole(factors_.rows), stride = whole(factors_.stride);
    const int columns = whole(sides.columns), side_stride = whole(sides.stride);
    int info = 0;
    cgetrs_("N", &rows, &columns, factors_.values.data(), &stride, pivots_.data(), sides.values.data(), &side_stride,
            &info);
    if (info != 0) throw Error(ErrorCode::failed, "scattering", fmt::format("LAPACK refuses argument {}", -info));
}

}  // namespace haptogram::scattering
