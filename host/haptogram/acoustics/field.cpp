// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/field.hpp"

#include <fmt/core.h>
#include <hwy/aligned_allocator.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <thread>

#include "haptogram/acoustics/coarse.hpp"
#include "haptogram/acoustics/interpolate.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/acoustics/shift.hpp"
#include "haptogram/acoustics/wave.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double coincident_m = 1e-9;  ///< a point nearer than this to an element counts as being on it

/// How many threads a call uses. The limit is TBB's own, normally one thread a processor; asking for more would only
/// make TBB print a warning. The call reads this limit and never sets it, because it belongs to the whole process.
unsigned workers(const FieldOptions& options) {
    const auto most =
        static_cast<unsigned>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    return options.threads == 0 ? most : std::min(options.threads, most);
}

/// Calls work(worker, unit) for every unit, on as many threads as `workers` says; `worker` numbers them from 0. What a
/// unit computes may not depend on its worker, so that the result is the same for any number of threads.
///
/// Every call has an arena of its own, so calls from several threads do not limit each other. Progress is told from the
/// calling thread alone. When it ends the work, units that have begun are finished, no further ones begin, and its
/// Error{cancelled} comes out of here.
template <class Work>
void in_parallel(std::size_t units, unsigned workers, const Progress& progress, Work work) {
    std::atomic<std::size_t> done = 0;
    const auto caller = std::this_thread::get_id();
    tbb::task_arena arena(static_cast<int>(workers));
    arena.execute([&] {
        tbb::parallel_for(std::size_t{0}, units, [&](std::size_t unit) {
            work(static_cast<unsigned>(tbb::this_task_arena::current_thread_index()), unit);
            const std::size_t finished = ++done;
            if (std::this_thread::get_id() == caller)
                progress(static_cast<double>(finished) / static_cast<double>(units));
        });
    });
    progress(1.0);
}

/// The points of one block, as they were asked for, and the box around them.
struct Points {
    std::array<double, WaveBlock::most> x, y, z;
    std::size_t count = 0;
    Vec3 low, high;

    [[nodiscard]] Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
};

std::size_t blocks_of(std::size_t points) { return (points + WaveBlock::most - 1) / WaveBlock::most; }

std::size_t end_of_block(std::size_t block, std::size_t points) {
    return std::min(points, (block + 1) * WaveBlock::most);
}

void take_block(std::span<const Vec3> from, std::size_t block, Points& points) {
    const auto part = from.subspan(block * WaveBlock::most, end_of_block(block, from.size()) - block * WaveBlock::most);
    points.low = points.high = part[0];
    points.count = 0;
    for (const Vec3& p : part) {
        points.low = {std::min(points.low.x, p.x), std::min(points.low.y, p.y), std::min(points.low.z, p.z)};
        points.high = {std::max(points.high.x, p.x), std::max(points.high.y, p.y), std::max(points.high.z, p.z)};
        points.x[points.count] = p.x;
        points.y[points.count] = p.y;
        points.z[points.count++] = p.z;
    }
}

/// The same of a grid. Whole rows are copied, because Grid::point() for each point takes longer than the wave of one
/// element to it. Blocks hold the same points in the same order as if the grid's points had been listed.
void take_block(const Grid& from, std::size_t block, Points& points) {
    const std::size_t columns = from.x.size(), rows = from.y.size();
    const std::size_t begin = block * WaveBlock::most, end = end_of_block(block, from.size());
    for (std::size_t i = begin, next = 0; i < end; i = next) {
        const std::size_t row = i / columns;
        next = std::min(end, (row + 1) * columns);
        std::copy(&from.x[i - row * columns], &from.x[i - row * columns] + (next - i), &points.x[i - begin]);
        std::fill_n(&points.y[i - begin], next - i, from.y[row % rows]);
        std::fill_n(&points.z[i - begin], next - i, from.z[row / rows]);
    }
    points.count = end - begin;
    const std::size_t first = begin / columns, last = (end - 1) / columns;
    const auto box = [](const std::vector<double>& axis, std::size_t a, std::size_t b, double& low, double& high) {
        low = high = axis[a];
        for (std::size_t i = a; i <= b; ++i) {
            low = std::min(low, axis[i]);
            high = std::max(high, axis[i]);
        }
    };
    const bool one_row = first == last, one_plane = first / rows == last / rows;
    box(from.x, one_row ? begin % columns : 0, one_row ? (end - 1) % columns : columns - 1, points.low.x,
        points.high.x);
    box(from.y, one_plane ? first % rows : 0, one_plane ? last % rows : rows - 1, points.low.y, points.high.y);
    box(from.z, first / rows, last / rows, points.low.z, points.high.z);
}

/// The elements that sound, what each of them plays, and how its wave spreads.
struct Sources {
    std::vector<Element> elements;
    std::vector<double> half_turns;  ///< phase of each drive, in units of π
    std::vector<float> amplitudes;
    WaveModel model;
    double half_turns_per_m = 0.0;

    /// @param pattern  of all elements, as fit_pattern() gives it
    Sources(const Array& array, std::vector<Element> at, const FittedPattern& pattern)
        : elements(std::move(at)),
          half_turns(elements.size()),
          amplitudes(elements.size(), 1.0F),
          half_turns_per_m(2.0 / array.wavelength_m()) {
        model.half_turns_per_m = static_cast<float>(half_turns_per_m);
        model.absorption_np_m = static_cast<float>(array.medium.absorption_np_m);
        model.pattern = pattern;
        model.tilted = std::any_of(elements.begin(), elements.end(), [](const Element& e) {
            return e.normal != Vec3{0.0, 0.0, 1.0};
        });
    }

    void play(Drives drives) {
        for (std::size_t m = 0; m < elements.size(); ++m) {
            half_turns[m] = std::arg(drives[m]) / std::numbers::pi;
            amplitudes[m] = static_cast<float>(std::abs(drives[m]));
        }
    }

    /// Makes all waves meet in phase everywhere: their sum is then the largest |p| that the drives, with any phases,
    /// could make.
    void align() {
        std::fill(half_turns.begin(), half_turns.end(), 0.0);
        half_turns_per_m = 0.0;
        model.half_turns_per_m = 0.0F;
    }
};

FittedPattern fitted(const Array& array, const FieldOptions& options) {
    return fit_pattern(array.transducer, 2.0 * std::numbers::pi / array.wavelength_m(), options.pattern_error);
}

void check(const Array& array, Drives drives) {
    if (drives.size() != array.elements.size())
        throw bad_input("field", fmt::format("found {} drives for {} elements; expected one each", drives.size(),
                                             array.elements.size()));
}

/// A block of points and the elements around it, in single precision and relative to the block's centre.
class PreparedBlock {
public:
    WaveBlock block;
    std::vector<WaveElement> elements;
    std::vector<std::size_t> near_points;  ///< too near to an element for single precision, in ascending order

    /// @throws Error{bad_input} when a point coincides with an element
    void set(const Sources& sources, const Points& points) {
        const Vec3 half = (points.high - points.low) * 0.5;
        const Vec3 centre = (points.high + points.low) * 0.5;
        centre_block(points.x.data(), points.y.data(), points.z.data(), points.count, centre, block);
        // Rounding moves a coordinate by about 1e-7 of the block's size. At a hundredth of the block's size from an
        // element, this is 1e-5 of the range; nearer, it would be more.
        const double near_m = std::max(2.0 * coincident_m, 0.01 * norm(half));
        near_points.clear();
        block.far = true;
        elements.resize(sources.elements.size());
        for (std::size_t m = 0; m < elements.size(); ++m) {
            const Vec3 e = sources.elements[m].position - centre;
            const Vec3 normal = sources.elements[m].normal;
            const double range = norm(e);
            const double behind = range * sources.half_turns_per_m - sources.half_turns[m];
            constexpr double round = 6755399441055744.0;  // 1.5·2⁵²; adding it rounds to a whole number
            const double phase = behind - 2.0 * ((behind / 2.0 + round) - round);
            elements[m] = {static_cast<float>(e.x),          static_cast<float>(e.y),      static_cast<float>(e.z),
                           static_cast<float>(range),        static_cast<float>(phase),    sources.amplitudes[m],
                           static_cast<float>(normal.x),     static_cast<float>(normal.y), static_cast<float>(normal.z),
                           static_cast<float>(range * range)};
            const Vec3 gap{std::max(0.0, std::abs(e.x) - half.x), std::max(0.0, std::abs(e.y) - half.y),
                           std::max(0.0, std::abs(e.z) - half.z)};
            block.far = block.far && 9.0 * dot(gap, gap) >= range * range;
            if (dot(gap, gap) < near_m * near_m) find_near(sources.elements[m].position, points, near_m);
        }
        std::sort(near_points.begin(), near_points.end());
        near_points.erase(std::unique(near_points.begin(), near_points.end()), near_points.end());
    }

private:
    void find_near(Vec3 element, const Points& points, double near_m) {
        for (std::size_t i = 0; i < points.count; ++i) {
            const Vec3 ray = points[i] - element;
            const double square = dot(ray, ray);
            if (square >= near_m * near_m) continue;
            if (square < coincident_m * coincident_m) throw coincidence();
            near_points.push_back(i);
        }
    }
};

/// Working memory of one thread.
struct Workplace {
    Points points;
    PreparedBlock prepared;
    alignas(64) std::array<float, WaveBlock::most> re, im;
};

std::vector<std::unique_ptr<Workplace>> workplaces(unsigned workers) {
    std::vector<std::unique_ptr<Workplace>> places(workers);
    for (auto& place : places) place = std::make_unique<Workplace>();
    return places;
}

/// Pressure at place.points, into place.re and place.im.
void sum_block(const Array& array, Drives drives, const Sources& sources, Workplace& place) {
    place.prepared.set(sources, place.points);
    sum_waves(sources.model, place.prepared.block, place.prepared.elements, place.re.data(), place.im.data());
    for (const std::size_t i : place.prepared.near_points) {
        std::complex<double> p = 0.0;
        for (std::size_t m = 0; m < sources.elements.size(); ++m)
            p += drives[m] * propagation(array, sources.elements[m], place.points[i]);
        place.re[i] = static_cast<float>(p.real());
        place.im[i] = static_cast<float>(p.imag());
    }
}

/// Sums every element's wave at every point of a list or a grid.
template <class Where>
void add_directly(const Array& array, const FittedPattern& pattern, Drives drives, const Where& where,
                  std::span<std::complex<float>> found, const FieldOptions& options) {
    Sources sources(array, array.elements, pattern);
    sources.play(drives);
    const unsigned threads = workers(options);
    const auto places = workplaces(threads);
    in_parallel(blocks_of(where.size()), threads, options.progress, [&](unsigned worker, std::size_t block) {
        Workplace& place = *places[worker];
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

    SharesOfRows(Drives drives, const ShiftedGrid& shifted, std::size_t columns) {
        const std::size_t rows = shifted.last_row + 1;
        const auto drive = [&](std::size_t of_row, std::size_t column) {
            const std::size_t m = of_row * columns + column;
            return of_row < rows && m < drives.size() ? std::complex<float>(drives[m]) : std::complex<float>();
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
    const Sources one(array, {Element{{0.0, 0.0, array.elements[0].position.z}}}, pattern);
    const std::complex<double> unit = 1.0;
    const std::size_t columns = shifted.x.size(), lattice = columns * shifted.y.size();
    // Each thread holds a lattice of its own, so memory limits the threads. It must not make pressure_on() choose the
    // direct sum instead, or the result would depend on the number of threads.
    const auto threads =
        static_cast<unsigned>(std::clamp<std::size_t>(most_lattice_points(grid) / lattice, 1, workers(options)));
    const SharesOfRows shares(drives, shifted, array.columns);
    std::vector<std::vector<float>> fields(threads);
    std::vector<std::vector<ShiftedShare>> placed(threads, shares.shares);
    const auto places = workplaces(threads);
    in_parallel(grid.z.size(), threads, options.progress, [&](unsigned worker, std::size_t plane) {
        Workplace& place = *places[worker];
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

/// What the steps of a method take, in vector instructions a point. They need not be exact: they only choose.
namespace cost {
constexpr double wave = 45.0;           ///< one element's wave
constexpr double share = 4.0;           ///< one shifted copy
constexpr double interpolation = 70.0;  ///< along x and y
}  // namespace cost

/// Sums on a grid, and what they take: by shifts if array and grid have any and these take less than summing every
/// wave.
struct Sums {
    std::optional<ShiftedGrid> shifted;
    double cost = 0.0;
};

/// A lattice must fit into memory. A plane within 1 mm of the elements goes to the direct sum, which computes points
/// near an element in double precision.
Sums plan_sums(const Array& array, const Grid& grid) {
    const auto points = static_cast<double>(grid.size()), elements = static_cast<double>(array.elements.size());
    const Sums direct{{}, points * elements * cost::wave};
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

void add_sums(const Array& array, const FittedPattern& pattern, Drives drives, const Grid& grid, const Sums& sums,
              std::span<std::complex<float>> found, const FieldOptions& options) {
    if (sums.shifted)
        add_shifted(array, pattern, drives, grid, *sums.shifted, found, options);
    else
        add_directly(array, pattern, drives, grid, found, options);
}

/// How far a field on a grid is from the sum of the waves, as PressureField::error says: at the grid's corners and at
/// points all over it, whose fractions of its sides are multiples of irrational numbers.
double deviation(const Array& array, const FittedPattern& pattern, Drives drives, const Grid& grid,
                 std::span<const std::complex<float>> found) {
    constexpr std::size_t checked = 64, corners = 8;
    const auto place = std::make_unique<Workplace>();
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
    Sources sources(array, array.elements, pattern);
    sources.play(drives);
    take_block(std::span<const Vec3>(points), 0, place->points);
    sum_block(array, drives, sources, *place);
    float off = 0.0F, most = 0.0F;
    for (std::size_t i = 0; i < checked; ++i)
        off = std::max(off, std::abs(found[indices[i]] - std::complex<float>(place->re[i], place->im[i])));
    sources.align();
    place->prepared.set(sources, place->points);
    sum_waves(sources.model, place->prepared.block, place->prepared.elements, place->re.data(), place->im.data());
    for (std::size_t i = 0; i < checked; ++i) most = std::max(most, place->re[i]);
    return most > 0.0F ? static_cast<double>(off / most) : 0.0;
}

/// What sums of waves in single precision are held to (tests/unit/test_kernel.cpp). Coordinates are rounded relative to
/// the blocks of points, so points that are spread over metres are less exact.
double error_of_sums(const Grid& grid) {
    double square = 0.0;
    for (const auto* axis : {&grid.x, &grid.y, &grid.z}) {
        if (axis->empty()) return 0.0;
        const auto [low, high] = std::minmax_element(axis->begin(), axis->end());
        square += (*high - *low) * (*high - *low);
    }
    return square <= 1.0 ? 3e-5 : 1e-4;
}
/// Points that are not checked may be further off than those that are.
constexpr double unseen = 2.0;

/// The field on a coarse grid, and interpolated from there.
void interpolate(const Array& array, const FittedPattern& pattern, Drives drives, const CoarseGrid& coarse,
                 std::span<std::complex<float>> found, const FieldOptions& options) {
    const Grid points = coarse.grid();
    const Sums sums = plan_sums(array, points);
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

/// The same in slabs of planes, one after the other, so that the coarse grid takes little memory beside the result: a
/// 32nd of it, or 2 MB. Neighbouring slabs both compute the coarse planes that both need.
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

/// Σ weight·|p|²/2 over Σ weight at every point of a list or a grid.
template <class Where>
std::vector<float> mean_square(const Array& array, std::span<const WeightedDrives> sequence, const Where& where,
                               const FieldOptions& options) {
    double total = 0.0;
    std::vector<WeightedDrives> played;
    for (const WeightedDrives& entry : sequence) {
        check(array, entry.drives);
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
            pair.re[r % 2] = static_cast<float>(played[r].drives[m].real());
            pair.im[r % 2] = static_cast<float>(played[r].drives[m].imag());
        }
    }
    const Sources sources(array, array.elements, fitted(array, options));
    const unsigned threads = workers(options);
    const auto places = workplaces(threads);
    std::vector<hwy::AlignedFreeUniquePtr<float[]>> scratch;
    for (std::size_t i = 0; i < places.size(); ++i)
        scratch.push_back(hwy::AllocateAligned<float>(std::max<std::size_t>(1, scratch_of_sum_squares(elements))));
    in_parallel(blocks_of(where.size()), threads, options.progress, [&](unsigned worker, std::size_t block) {
        Workplace& place = *places[worker];
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
    check(array, drives);
    std::vector<std::complex<float>> found(points.size());
    add_directly(array, fitted(array, options), drives, points, found, options);
    return found;
}

std::vector<PressureGradient> pressure_gradient_at(const Array& array, Drives drives, std::span<const Vec3> points,
                                                   const FieldOptions& options) {
    check(array, drives);
    Sources sources(array, array.elements, fitted(array, options));
    sources.play(drives);
    const bool by_table = sources.model.pattern.kind == FittedPattern::Kind::table;
    const unsigned threads = workers(options);
    const auto places = workplaces(threads);
    std::vector<std::array<std::array<float, WaveBlock::most>, 6>> sums(threads);
    std::vector<PressureGradient> found(points.size());
    in_parallel(blocks_of(points.size()), threads, options.progress, [&](unsigned worker, std::size_t block) {
        Workplace& place = *places[worker];
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
    check(array, drives);
    PressureField found;
    found.values.resize(grid.size());
    found.error = error_of_sums(grid);
    const FittedPattern pattern = fitted(array, options);
    found.pattern_error = pattern.error;
    const Sums sums = plan_sums(array, grid);
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
    for (const WeightedDrives& entry : sequence) check(array, entry.drives);
    const Drives drives = std::find_if(sequence.begin(), sequence.end(), plays)->drives;
    const PressureField field = pressure_field(array, drives, grid, options);
    MeanSquareField found{std::vector<float>(field.values.size()), field.method, field.error};
    std::transform(field.values.begin(), field.values.end(), found.values.begin(),
                   [](std::complex<float> p) { return std::norm(p) / 2.0F; });
    return found;
}

}  // namespace haptogram
