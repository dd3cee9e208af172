// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/field.hpp"

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <array>
#include <optional>

#include "haptogram/acoustics/coarse.hpp"
#include "haptogram/acoustics/field_blocks.hpp"
#include "haptogram/acoustics/field_interpolated.hpp"
#include "haptogram/acoustics/field_sums.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"

namespace haptogram {
namespace {

/// Points that are not checked may be further off than those that are.
constexpr double unseen = 2.0;

/// Σ weight·|p|²/2 over Σ weight at every point of a list or a grid.
template <class Where>
std::vector<float> mean_square(const Array& array, std::span<const WeightedDrives> sequence, const Where& where,
                               const FieldOptions& options) {
    double total = 0.0;
    std::vector<WeightedDrives> played;
    for (const WeightedDrives& entry : sequence) {
        require_drives(array, entry.drives);
        total += entry.weight;
        if (entry.weight != 0.0) played.push_back(entry);
    }
    std::vector<float> mean(where.size());
    const std::size_t elements = array.elements.size(), pairs = (played.size() + 1) / 2;
    std::vector<float> weights(2 * pairs);
    std::vector<DrivePair> drives(pairs * elements);
    for (std::size_t r = 0; r < played.size(); ++r) {
        weights[r] = static_cast<float>(played[r].weight / total / 2.0);
        for (std::size_t m = 0; m < elements; ++m) {
            DrivePair& pair = drives[r / 2 * elements + m];
            const std::complex<double> radiated = played[r].drives[m] * array.elements[m].response;
            pair.re[r % 2] = static_cast<float>(radiated.real());
            pair.im[r % 2] = static_cast<float>(radiated.imag());
        }
    }
    const FieldSources sources(array, array.elements, fitted_pattern(array, options));
    const unsigned threads = workers(options);
    const auto places = workplaces(threads);
    std::vector<hwy::AlignedFreeUniquePtr<float[]>> scratch;
    for (std::size_t i = 0; i < places.size(); ++i)
        scratch.push_back(hwy::AllocateAligned<float>(std::max<std::size_t>(1, scratch_of_sum_squares(elements))));
    in_parallel(blocks_of(where.size()), threads, options.progress, [&](unsigned worker, std::size_t block) {
        FieldWorkplace& place = *places[worker];
        take_block(where, block, place.points);
        place.prepared.set(sources, place.points);
        sum_squares(sources.model, place.prepared.block, place.prepared.elements, drives, weights,
                    scratch[worker].get(), place.re.data());
        for (const std::size_t i : place.prepared.near_points) {
            std::vector<std::complex<double>> column;
            for (const Element& e : array.elements) column.push_back(propagation(array, e, place.points[i]));
            double sum = 0.0;
            for (const WeightedDrives& entry : played) {
                std::complex<double> p = 0.0;
                for (std::size_t m = 0; m < elements; ++m) p += entry.drives[m] * column[m];
                sum += entry.weight / total / 2.0 * std::norm(p);
            }
            place.re[i] = static_cast<float>(sum);
        }
        std::copy_n(place.re.begin(), place.points.count,
                    mean.begin() + static_cast<std::ptrdiff_t>(block * WaveBlock::most));
    });
    return mean;
}

}  // namespace

const char* name_of(FieldMethod method) {
    return method == FieldMethod::sums ? "sums" : method == FieldMethod::shifts ? "shifts" : "interpolated";
}

std::vector<std::complex<float>> pressure_at(const Array& array, Drives drives, std::span<const Vec3> points,
                                             const FieldOptions& options) {
    require_drives(array, drives);
    std::vector<std::complex<float>> found(points.size());
    add_directly(array, fitted_pattern(array, options), drives, points, found, options);
    return found;
}

std::vector<PressureGradient> pressure_gradient_at(const Array& array, Drives drives, std::span<const Vec3> points,
                                                   const FieldOptions& options) {
    require_drives(array, drives);
    FieldSources sources(array, array.elements, fitted_pattern(array, options));
    sources.play(drives);
    const bool by_table = sources.model.pattern.kind == FittedPattern::Kind::table;
    const unsigned threads = workers(options);
    const auto places = workplaces(threads);
    std::vector<std::array<std::array<float, WaveBlock::most>, 6>> sums(threads);
    std::vector<PressureGradient> found(points.size());
    in_parallel(blocks_of(points.size()), threads, options.progress, [&](unsigned worker, std::size_t block) {
        FieldWorkplace& place = *places[worker];
        PressureGradient* to = &found[block * WaveBlock::most];
        const auto in_double = [&](std::size_t i) {
            const ComplexVec3 slope = pressure_gradient(array, drives, place.points[i]);
            to[i] = {std::complex<float>(slope.x), std::complex<float>(slope.y), std::complex<float>(slope.z)};
        };
        take_block(points, block, place.points);
        place.prepared.set(sources, place.points);
        if (by_table) {
            for (std::size_t i = 0; i < place.points.count; ++i) in_double(i);
            return;
        }
        auto& s = sums[worker];
        sum_gradients(sources.model, place.prepared.block, place.prepared.elements,
                      {s[0].data(), s[1].data(), s[2].data(), s[3].data(), s[4].data(), s[5].data()});
        for (std::size_t i = 0; i < place.points.count; ++i)
            to[i] = {{s[0][i], s[1][i]}, {s[2][i], s[3][i]}, {s[4][i], s[5][i]}};
        for (const std::size_t i : place.prepared.near_points) in_double(i);
    });
    return found;
}

PressureField pressure_field(const Array& array, Drives drives, const Grid& grid, const FieldOptions& options) {
    require_drives(array, drives);
    PressureField found;
    found.values.resize(grid.size());
    found.error = error_of_sums(grid);
    const FittedPattern pattern = fitted_pattern(array, options);
    found.pattern_error = pattern.error;
    const PlannedSums sums = plan_sums(array, grid);
    FieldOptions rest = options;
    const auto coarse =
        options.interpolation_error > found.error ? find_coarse_grid(array, grid) : std::optional<CoarseGrid>();
    if (coarse && plan_sums(array, coarse->grid()).cost + static_cast<double>(grid.size()) * cost::interpolation <
                      0.8 * sums.cost) {
        constexpr double most = 0.9;  // of the progress; what is left is for the case that its error is too large
        FieldOptions part = options;
        part.progress = options.progress.between(0.0, most);
        interpolate_slabs(array, pattern, drives, *coarse, found.values, part);
        const double error = found.error + unseen * deviation(array, pattern, drives, grid, found.values);
        if (error <= options.interpolation_error) {
            options.progress(1.0);
            found.method = FieldMethod::interpolated;
            found.error = error;
            return found;
        }
        rest.progress = options.progress.between(most, 1.0);
    }
    found.method = sums.shifted ? FieldMethod::shifts : FieldMethod::sums;
    add_sums(array, pattern, drives, grid, sums, found.values, rest);
    return found;
}

std::vector<std::complex<float>> pressure_on(const Array& array, Drives drives, const Grid& grid,
                                             const FieldOptions& options) {
    return pressure_field(array, drives, grid, options).values;
}

std::vector<float> mean_square_pressure_at(const Array& array, std::span<const WeightedDrives> sequence,
                                           std::span<const Vec3> points, const FieldOptions& options) {
    return mean_square(array, sequence, points, options);
}

std::vector<float> mean_square_pressure(const Array& array, std::span<const WeightedDrives> sequence, const Grid& grid,
                                        const FieldOptions& options) {
    return mean_square_field(array, sequence, grid, options).values;
}

MeanSquareField mean_square_field(const Array& array, std::span<const WeightedDrives> sequence, const Grid& grid,
                                  const FieldOptions& options) {
    const auto plays = [](const WeightedDrives& entry) { return entry.weight != 0.0; };
    if (std::count_if(sequence.begin(), sequence.end(), plays) != 1)
        return {mean_square(array, sequence, grid, options), FieldMethod::sums, error_of_sums(grid)};
    for (const WeightedDrives& entry : sequence) require_drives(array, entry.drives);
    const Drives drives = std::find_if(sequence.begin(), sequence.end(), plays)->drives;
    const PressureField field = pressure_field(array, drives, grid, options);
    MeanSquareField found{std::vector<float>(field.values.size()), field.method, field.error};
    std::transform(field.values.begin(), field.values.end(), found.values.begin(),
                   [](std::complex<float> p) { return std::norm(p) / 2.0F; });
    return found;
}

}  // namespace haptogram
