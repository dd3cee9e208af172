// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/field_interpolated.hpp"

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "haptogram/acoustics/field_blocks.hpp"
#include "haptogram/acoustics/field_sums.hpp"
#include "haptogram/acoustics/interpolate.hpp"

namespace haptogram {
namespace {

/// The field on a coarse grid, and interpolated from there.
void interpolate(const Array& array, const FittedPattern& pattern, Drives drives, const CoarseGrid& coarse,
                 std::span<std::complex<float>> found, const FieldOptions& options) {
    const Grid points = coarse.grid();
    const PlannedSums sums = plan_sums(array, points);
    std::vector<std::complex<float>> values(points.size() + interpolation_overrun);
    FieldOptions part = options;
    const double share = sums.cost / (sums.cost + static_cast<double>(found.size()) * cost::interpolation);
    part.progress = options.progress.between(0.0, share);
    add_sums(array, pattern, drives, points, sums, std::span(values).first(points.size()), part);

    constexpr std::size_t rows = 64;
    const std::size_t strips = (coarse.y.size + rows - 1) / rows;
    const unsigned threads = workers(options);
    std::vector<hwy::AlignedFreeUniquePtr<float[]>> scratch;
    for (unsigned i = 0; i < threads; ++i)
        scratch.push_back(hwy::AllocateAligned<float>(scratch_of_interpolation(coarse, rows)));
    in_parallel(coarse.z.size * strips, threads, options.progress.between(share, 1.0),
                [&](unsigned worker, std::size_t strip) {
                    const std::size_t plane = strip / strips, begin = strip % strips * rows;
                    const std::size_t end = std::min(begin + rows, coarse.y.size);
                    interpolate_rows(coarse, values.data(), plane, begin, end, scratch[worker].get(),
                                     &found[(plane * coarse.y.size + begin) * coarse.x.size]);
                });
}

}  // namespace

void interpolate_slabs(const Array& array, const FittedPattern& pattern, Drives drives, const CoarseGrid& coarse,
                       std::span<std::complex<float>> found, const FieldOptions& options) {
    const std::size_t planes = coarse.z.size, most = std::max<std::size_t>(found.size() / 32, std::size_t{1} << 18U);
    const auto coarse_points = [&](std::size_t of_slab) {
        return coarse.x.coarse.size() * coarse.y.coarse.size() *
               (coarse.z.coarse.size() * of_slab / planes + coarse.z.taps);
    };
    std::size_t slab = planes;
    while (slab > 32 && coarse_points(slab) > most) slab -= slab / 8;
    for (std::size_t begin = 0; begin < planes; begin += slab) {
        const std::size_t end = std::min(begin + slab, planes), plane = coarse.x.size * coarse.y.size;
        FieldOptions part = options;
        part.progress = options.progress.between(static_cast<double>(begin) / static_cast<double>(planes),
                                                 static_cast<double>(end) / static_cast<double>(planes));
        interpolate(array, pattern, drives, {coarse.x, coarse.y, part_of(coarse.z, begin, end)},
                    found.subspan(begin * plane, (end - begin) * plane), part);
    }
}

double deviation(const Array& array, const FittedPattern& pattern, Drives drives, const Grid& grid,
                 std::span<const std::complex<float>> found) {
    constexpr std::size_t checked = 64, corners = 8;
    const auto place = std::make_unique<FieldWorkplace>();
    std::array<std::size_t, checked> indices{};
    const auto at = [](const std::vector<double>& axis, double fraction) {
        return std::min(axis.size() - 1, static_cast<std::size_t>(fraction * static_cast<double>(axis.size())));
    };
    const auto part = [](std::size_t i, double irrational) {
        const double turns = static_cast<double>(i) * irrational + 0.5;
        return turns - std::floor(turns);
    };
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < checked; ++i) {
        const std::size_t x = i < corners ? i % 2 * (grid.x.size() - 1) : at(grid.x, part(i, 0.8191725133961645));
        const std::size_t y = i < corners ? i / 2 % 2 * (grid.y.size() - 1) : at(grid.y, part(i, 0.6710436067037893));
        const std::size_t z = i < corners ? i / 4 * (grid.z.size() - 1) : at(grid.z, part(i, 0.5497004779019703));
        indices[i] = (z * grid.y.size() + y) * grid.x.size() + x;
        points.push_back(grid.point(indices[i]));
    }
    FieldSources sources(array, array.elements, pattern);
    sources.play(drives);
    take_block(std::span<const Vec3>(points), 0, place->points);
    sum_block(array, drives, sources, *place);
    double off = 0.0;
    for (std::size_t i = 0; i < checked; ++i) {
        const std::complex<double> found_here = found[indices[i]];
        off = std::max(off, std::norm(found_here - std::complex<double>(place->re[i], place->im[i])));
    }
    sources.align();
    place->prepared.set(sources, place->points);
    sum_waves(sources.model, place->prepared.block, place->prepared.elements, place->re.data(), place->im.data());
    float most = 0.0F;
    for (std::size_t i = 0; i < checked; ++i) most = std::max(most, place->re[i]);
    return most > 0.0F ? std::sqrt(off) / static_cast<double>(most) : 0.0;
}

}  // namespace haptogram
