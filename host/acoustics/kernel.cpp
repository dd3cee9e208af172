// SPDX-License-Identifier: Apache-2.0
#include "acoustics/kernel.hpp"

#include "acoustics/field.hpp"

namespace haptogram {

std::vector<std::complex<float>> pressure_at(const Array& array, Drives drives, std::span<const Vec3> points,
                                             const FieldOptions& options) {
    std::vector<std::complex<float>> found(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        found[i] = std::complex<float>(pressure(array, drives, points[i]));
        options.progress(static_cast<double>(i + 1) / static_cast<double>(points.size()));
    }
    return found;
}

std::vector<std::complex<float>> pressure_on(const Array& array, Drives drives, const Grid& grid,
                                             const FieldOptions& options) {
    std::vector<std::complex<float>> found(grid.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        found[i] = std::complex<float>(pressure(array, drives, grid.point(i)));
        options.progress(static_cast<double>(i + 1) / static_cast<double>(found.size()));
    }
    return found;
}

std::vector<float> mean_square_pressure(const Array& array, std::span<const WeightedDrives> sequence, const Grid& grid,
                                        const FieldOptions& options) {
    std::vector<float> mean(grid.size());
    double total = 0.0;
    for (const WeightedDrives& entry : sequence) total += entry.weight;
    for (const WeightedDrives& entry : sequence) {
        if (entry.weight == 0.0) continue;
        const auto p = pressure_on(array, entry.drives, grid, options);
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += static_cast<float>(entry.weight / total / 2.0) * std::norm(p[i]);
    }
    return mean;
}

}  // namespace haptogram
