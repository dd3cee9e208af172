// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/field_sums.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "haptogram/acoustics/field_blocks.hpp"

namespace haptogram {
namespace {

/// Sums every element's wave at every point of a list or a grid.
template <class Where>
void add_all(const Array& array, const FittedPattern& pattern, Drives drives, const Where& where,
             std::span<std::complex<float>> found, const FieldOptions& options) {
    FieldSources sources(array, array.elements, pattern);
    sources.play(drives);
    const unsigned threads = workers(options);
    const auto places = workplaces(threads);
    in_parallel(blocks_of(where.size()), threads, options.progress, [&](unsigned worker, std::size_t block) {
        FieldWorkplace& place = *places[worker];
        take_block(where, block, place.points);
        sum_block(array, drives, sources, place);
        std::complex<float>* to = &found[block * WaveBlock::most];
        for (std::size_t i = 0; i < place.points.count; ++i) to[i] = {place.re[i], place.im[i]};
    });
}

/// Which parts of one element's field add up to the pressure on a row of a grid and on the row one pitch further on.
/// They are the same for all such pairs of rows, but for where the parts' rows are in the lattice.
///
/// Two such rows need almost the same parts, because one row of points lies relative to one row of elements exactly as
/// the second row of points lies relative to the next row of elements. So both take the same row of the lattice, with
/// drives from neighbouring rows of elements, and what is loaded once serves both.
struct SharesOfRows {
    std::vector<ShiftedShare> shares;  ///< each begins at a column, in a row that is not yet known
    std::vector<std::size_t> ends;     ///< behind those in the first of the rows, in the second, …

    SharesOfRows(const Array& array, Drives drives, const ShiftedGrid& shifted) {
        const std::size_t columns = array.columns;
        const std::size_t rows = shifted.last_row + 1;
        const auto drive = [&](std::size_t of_row, std::size_t column) {
            const std::size_t m = of_row * columns + column;
            return of_row < rows && m < drives.size() ? std::complex<float>(drives[m] * array.elements[m].response)
                                                      : std::complex<float>();
        };
        for (std::size_t i = 0; i <= rows; ++i) {
            for (std::size_t column = 0; column <= shifted.last_column; ++column) {
                // Below zero the unsigned index becomes huge: there is no such row of elements, and drive() gives 0.
                const auto first = drive(shifted.last_row - i, column),
                           second = drive(shifted.last_row + 1 - i, column);
                if (first == 0.0F && second == 0.0F) continue;
                shares.push_back(
                    {shifted.column(column), {{first.real(), second.real()}, {first.imag(), second.imag()}}});
            }
            ends.push_back(shares.size());
        }
    }

    /// Those of the grid's row `row` and, with `pair`, of the row one pitch further on.
    /// @param room  a copy of `shares`
    [[nodiscard]] std::span<const ShiftedShare> place(const ShiftedGrid& shifted, std::size_t row, bool pair,
                                                      std::span<ShiftedShare> room) const {
        std::size_t next = 0;
        for (std::size_t i = 0; i < ends.size() - (pair ? 0 : 1); ++i) {
            const std::size_t at = shifted.rows[row + i * shifted.step_rows] * shifted.x.size();
            for (; next < ends[i]; ++next) room[next].at = at + shares[next].at;
        }
        return room.first(next);
    }
};

/// The most lattice points that all threads together may hold: as many as the result has, or 2²¹, which are 16 MB.
std::size_t most_lattice_points(const Grid& grid) { return std::max(grid.size(), std::size_t{1} << 21U); }

/// Pressure on a grid that find_shifts() accepts. In each plane, one element's field is computed on the lattice once;
/// then every element's field is that field, shifted to where the element is and multiplied by its drive.
void add_shifted(const Array& array, const FittedPattern& pattern, Drives drives, const Grid& grid,
                 const ShiftedGrid& shifted, std::span<std::complex<float>> found, const FieldOptions& options) {
    const FieldSources one(array, {Element{{0.0, 0.0, array.elements[0].position.z}}}, pattern);
    const std::complex<double> unit = 1.0;
    const std::size_t columns = shifted.x.size(), lattice = columns * shifted.y.size();
    // Each thread holds a lattice of its own, so memory limits the threads. It must not make pressure_on() choose the
    // direct sum instead, or the result would depend on the number of threads.
    const auto threads =
        static_cast<unsigned>(std::clamp<std::size_t>(most_lattice_points(grid) / lattice, 1, workers(options)));
    const SharesOfRows shares(array, drives, shifted);
    std::vector<std::vector<float>> fields(threads);
    std::vector<std::vector<ShiftedShare>> placed(threads, shares.shares);
    const auto places = workplaces(threads);
    in_parallel(grid.z.size(), threads, options.progress, [&](unsigned worker, std::size_t plane) {
        FieldWorkplace& place = *places[worker];
        std::vector<float>& field = fields[worker];
        field.resize(2 * (lattice + shifted_tile));
        float* field_re = field.data();
        float* field_im = field_re + lattice + shifted_tile;
        const Grid level{shifted.x, shifted.y, {grid.z[plane]}};
        for (std::size_t block = 0; block < blocks_of(lattice); ++block) {
            take_block(level, block, place.points);
            sum_block(array, {&unit, 1}, one, place);
            std::copy_n(place.re.begin(), place.points.count, field_re + block * WaveBlock::most);
            std::copy_n(place.im.begin(), place.points.count, field_im + block * WaveBlock::most);
        }
        for (std::size_t row = 0; row < grid.y.size(); ++row) {
            if (row / shifted.step_rows % 2 == 1) continue;  // computed already, as the second row of a pair
            const std::size_t next = row + shifted.step_rows;
            const bool pair = next < grid.y.size();
            std::complex<float>* first = &found[(plane * grid.y.size() + row) * grid.x.size()];
            std::complex<float>* second = pair ? first + (next - row) * grid.x.size() : nullptr;
            sum_shifted(field_re, field_im, shares.place(shifted, row, pair, placed[worker]), first, second,
                        grid.x.size());
        }
    });
}

}  // namespace

PlannedSums plan_sums(const Array& array, const Grid& grid) {
    const auto points = static_cast<double>(grid.size()), elements = static_cast<double>(array.elements.size());
    const PlannedSums direct{{}, points * elements * cost::wave};
    if (grid.x.size() < 8 || elements < 4) return direct;
    for (const double z : grid.z)
        if (!(std::abs(z - array.elements[0].position.z) >= 1e-3)) return direct;
    auto shifted = find_shifts(array, grid);
    if (!shifted) return direct;
    const std::size_t lattice = shifted->x.size() * shifted->y.size();
    const std::size_t waves = grid.x.size() * grid.y.size() * array.elements.size();
    if (lattice > most_lattice_points(grid) || lattice > waves / 2) return direct;
    const double most = static_cast<double>(lattice * grid.z.size()) * cost::wave + points * elements * cost::share;
    return {std::move(shifted), most};
}

void add_directly(const Array& array, const FittedPattern& pattern, Drives drives, std::span<const Vec3> points,
                  std::span<std::complex<float>> found, const FieldOptions& options) {
    add_all(array, pattern, drives, points, found, options);
}

void add_sums(const Array& array, const FittedPattern& pattern, Drives drives, const Grid& grid,
              const PlannedSums& sums, std::span<std::complex<float>> found, const FieldOptions& options) {
    if (sums.shifted)
        add_shifted(array, pattern, drives, grid, *sums.shifted, found, options);
    else
        add_all(array, pattern, drives, grid, found, options);
}

double error_of_sums(const Grid& grid) {
    double square = 0.0;
    for (const auto* axis : {&grid.x, &grid.y, &grid.z}) {
        if (axis->empty()) return 0.0;
        const auto [low, high] = std::minmax_element(axis->begin(), axis->end());
        square += (*high - *low) * (*high - *low);
    }
    return square <= 1.0 ? 3e-5 : 1e-4;
}

}  // namespace haptogram
