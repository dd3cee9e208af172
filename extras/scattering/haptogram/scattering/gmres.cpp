// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/gmres.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::scattering {
namespace {

using Complex = std::complex<double>;
using Column = Eigen::Map<Eigen::VectorXcf>;
using ConstColumn = Eigen::Map<const Eigen::VectorXcf>;

Column column(DenseMatrix& m, std::size_t c) { return {m.column(c), static_cast<Eigen::Index>(m.rows)}; }
ConstColumn column(const DenseMatrix& m, std::size_t c) { return {m.column(c), static_cast<Eigen::Index>(m.rows)}; }

/// The small least-squares problem of one right-hand side: min |βe₁ − Hy|, kept triangular by Givens rotations.
class SmallProblem {
public:
    SmallProblem(double length, std::size_t most) : rest_{length}, columns_() { columns_.reserve(most); }

    /// @param h  the new column of H, one longer than the one before
    void add(std::vector<Complex> h) {
        const std::size_t last = columns_.size();
        for (std::size_t i = 0; i < last; ++i) {
            const Complex upper = h[i];
            h[i] = cosines_[i] * upper + sines_[i] * h[i + 1];
            h[i + 1] = -std::conj(sines_[i]) * upper + cosines_[i] * h[i + 1];
        }
        const double length = std::sqrt(std::norm(h[last]) + std::norm(h[last + 1]));
        const Complex turn = std::abs(h[last]) > 0.0 ? h[last] / std::abs(h[last]) : Complex(1.0);
        const double cosine = length > 0.0 ? std::abs(h[last]) / length : 1.0;
        const Complex sine = length > 0.0 ? turn * std::conj(h[last + 1]) / length : Complex(0.0);
        h[last] = turn * length;
        cosines_.push_back(cosine);
        sines_.push_back(sine);
        rest_.push_back(-std::conj(sine) * rest_[last]);
        rest_[last] *= cosine;
        h.pop_back();
        columns_.push_back(std::move(h));
    }
    [[nodiscard]] double residual() const { return std::abs(rest_.back()); }
    [[nodiscard]] std::vector<Complex> solution() const {
        std::vector<Complex> y(columns_.size());
        for (std::size_t i = y.size(); i-- > 0;) {
            y[i] = rest_[i];
            for (std::size_t j = i + 1; j < y.size(); ++j) y[i] -= columns_[j][i] * y[j];
            y[i] /= columns_[i][i];
        }
        return y;
    }

private:
    std::vector<Complex> rest_, sines_;
    std::vector<double> cosines_;
    std::vector<std::vector<Complex>> columns_;
};

}  // namespace

Iterated gmres(const DenseMatrix& matrix, const DenseMatrix& sides, double tolerance, std::size_t most_rounds) {
    const std::size_t count = sides.columns;
    std::vector<double> lengths;
    std::vector<SmallProblem> problems;
    std::vector<DenseMatrix> basis(1, DenseMatrix(sides.rows, count));
    for (std::size_t s = 0; s < count; ++s) {
        lengths.push_back(static_cast<double>(column(sides, s).norm()));
        problems.emplace_back(lengths.back(), most_rounds);
        if (lengths.back() > 0.0) column(basis[0], s) = column(sides, s) / static_cast<float>(lengths.back());
    }
    Iterated found{DenseMatrix(sides.rows, count), 0, 0.0};
    const auto worst = [&] {
        double most = 0.0;
        for (std::size_t s = 0; s < count; ++s)
            if (lengths[s] > 0.0) most = std::max(most, problems[s].residual() / lengths[s]);
        return most;
    };
    while ((found.residual = worst()) > tolerance) {
        if (found.rounds == most_rounds)
            throw Error(ErrorCode::failed, "scattering",
                        fmt::format("after {} rounds the residual is still {:.1e}; the mesh may have triangles that "
                                    "touch or cross each other",
                                    found.rounds, found.residual));
        basis.emplace_back(sides.rows, count);
        multiply(matrix, basis[found.rounds], basis.back());
        ++found.rounds;
        for (std::size_t s = 0; s < count; ++s) {
            if (lengths[s] == 0.0) continue;
            Column next = column(basis.back(), s);
            std::vector<Complex> h;
            for (std::size_t i = 0; i < found.rounds; ++i) {
                const Column one = column(basis[i], s);
                const std::complex<float> along = one.dot(next);  // the first one conjugated
                next -= along * one;
                h.emplace_back(along);
            }
            const float length = next.norm();
            h.emplace_back(length);
            if (length > 0.0F) next /= length;
            problems[s].add(std::move(h));
        }
    }
    for (std::size_t s = 0; s < count; ++s) {
        if (lengths[s] == 0.0) continue;
        const std::vector<Complex> y = problems[s].solution();
        for (std::size_t i = 0; i < y.size(); ++i)
            column(found.solutions, s) += std::complex<float>(y[i]) * column(basis[i], s);
    }
    return found;
}

}  // namespace haptogram::scattering
