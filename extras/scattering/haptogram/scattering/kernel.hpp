// SPDX-License-Identifier: Apache-2.0
// The loops behind boundary_matrix.hpp, in single precision and with the processor's vector instructions.
#pragma once
#include <complex>
#include <cstddef>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram::scattering {

/// What is summed: K + βH with the kernels K = ∂G/∂n_y and H = ∂²G/∂n_x∂n_y of Green's function G = e^{−jkr}/(4πr)
/// between a point x on the body, with its normal n_x, and a source y with its normal n_y; β = −j·coupling (Burton and
/// Miller 1971).
struct Kernel {
    double wave_number = 0.0;  ///< k, rad/m
    double coupling_m = 0.0;   ///< metres; 0: K alone
};

/// Points with normals and weights, in single precision, from a common origin that is near them. Rows are padded to
/// whole vectors of any processor with points of weight 0.
struct KernelPoints {
    static constexpr std::size_t lane_limit = 16;  ///< most floats of a vector
    std::vector<float> x, y, z, nx, ny, nz, weight;

    [[nodiscard]] static std::size_t padded(std::size_t count) {
        return (count + lane_limit - 1) / lane_limit * lane_limit;
    }
    void clear();
    void add(Vec3 point, Vec3 normal, double point_weight);
    /// Fills up the last vector.
    void pad();
};

/// Minus the kernel from one source to every point: what a column of the matrix holds away from its diagonal. A point
/// at the source itself gets 0.
/// @param weight  of the source, its area
/// @param column  room for KernelPoints::padded() values
void kernel_column(const Kernel& kernel, const KernelPoints& points, Vec3 source, Vec3 normal, double weight,
                   std::complex<float>* column);

/// The kernel summed over weighted sources, at one point.
[[nodiscard]] std::complex<float> kernel_sum(const Kernel& kernel, const KernelPoints& sources, Vec3 point,
                                             Vec3 normal);

}  // namespace haptogram::scattering
