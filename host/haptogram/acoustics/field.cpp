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

#include "haptogram/acoustics/propagation.hpp"
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

    Sources(const Array& array, std::vector<Element> at)
        : elements(std::move(at)),
          half_turns(elements.size()),
          amplitudes(elements.size(), 1.0F),
          half_turns_per_m(2.0 / array.wavelength_m()) {
        model.half_turns_per_m = static_cast<float>(half_turns_per_m);
        model.absorption_np_m = static_cast<float>(array.medium.absorption_np_m);
        model.pattern = fit_pattern(array.transducer, std::numbers::pi * half_turns_per_m);
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
};

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
        elements.resize(sources.elements.size());
        for (std::size_t m = 0; m < elements.size(); ++m) {
            const Vec3 e = sources.elements[m].position - centre;
            const Vec3 normal = sources.elements[m].normal;
            const double range = norm(e);
            const double behind = range * sources.half_turns_per_m - sources.half_turns[m];
            constexpr double round = 6755399441055744.0;  // 1.5·2⁵²; adding it rounds to a whole number
            const double phase = behind - 2.0 * ((behind / 2.0 + round) - round);
            elements[m] = {static_cast<float>(e.x),      static_cast<float>(e.y),      static_cast<float>(e.z),
                           static_cast<float>(range),    static_cast<float>(phase),    sources.amplitudes[m],
                           static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)};
            const Vec3 gap{std::max(0.0, std::abs(e.x) - half.x), std::max(0.0, std::abs(e.y) - half.y),
                           std::max(0.0, std::abs(e.z) - half.z)};
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
void add_directly(const Array& array, Drives drives, const Where& where, std::span<std::complex<float>> found,
                  const FieldOptions& options) {
    Sources sources(array, array.elements);
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

/// Lists which parts of one element's field add up to the pressure on the grid's row `row` and, with `pair`, on the row
/// one pitch further on.
///
/// Two such rows need almost the same parts, because one row of points lies relative to one row of elements exactly as
/// the second row of points lies relative to the next row of elements. So both take the same row of the lattice, with
/// drives from neighbouring rows of elements, and what is loaded once serves both.
void set_shares(const Array& array, Drives drives, const ShiftedGrid& shifted, std::size_t row, bool pair,
                std::vector<ShiftedShare>& shares) {
    shares.clear();
    const std::size_t columns = array.columns, rows = shifted.last_row + 1;
    const auto drive = [&](std::size_t of_row, std::size_t column) {
        const std::size_t m = of_row * columns + column;
        return of_row < rows && m < drives.size() ? std::complex<float>(drives[m]) : std::complex<float>();
    };
    for (std::size_t i = 0; i < rows + (pair ? 1 : 0); ++i) {
        const std::size_t at = shifted.rows[row + i * shifted.step_rows] * shifted.x.size();
        for (std::size_t column = 0; column <= shifted.last_column; ++column) {
            // Below zero the unsigned index becomes huge: there is no such row of elements, and drive() gives 0.
            const auto a = drive(shifted.last_row - i, column), b = drive(shifted.last_row + 1 - i, column);
            if (a == 0.0F && b == 0.0F) continue;
            shares.push_back({at + shifted.column(column), {{a.real(), b.real()}, {a.imag(), b.imag()}}});
        }
    }
}

/// The most lattice points that all threads together may hold: as many as the result has, or 2²¹, which are 16 MB.
std::size_t most_lattice_points(const Grid& grid) { return std::max(grid.size(), std::size_t{1} << 21U); }

/// Pressure on a grid that find_shifts() accepts. In each plane, one element's field is computed on the lattice once;
/// then every element's field is that field, shifted to where the element is and multiplied by its drive.
void add_shifted(const Array& array, Drives drives, const Grid& grid, const ShiftedGrid& shifted,
                 std::span<std::complex<float>> found, const FieldOptions& options) {
    const Sources one(array, {Element{{0.0, 0.0, array.elements[0].position.z}}});
    const std::complex<double> unit = 1.0;
    const std::size_t columns = shifted.x.size(), lattice = columns * shifted.y.size();
    // Each thread holds a lattice of its own, so memory limits the threads. It must not make pressure_on() choose the
    // direct sum instead, or the result would depend on the number of threads.
    const auto threads =
        static_cast<unsigned>(std::clamp<std::size_t>(most_lattice_points(grid) / lattice, 1, workers(options)));
    std::vector<std::vector<float>> fields(threads);
    std::vector<std::vector<ShiftedShare>> shares(threads);
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
            set_shares(array, drives, shifted, row, pair, shares[worker]);
            sum_shifted(field_re, field_im, shares[worker], first, second, grid.x.size());
        }
    });
}

/// The shifts of array and grid, if using them is faster than the direct sum: a plane's lattice must have far fewer
/// points than the plane has pairs of point and element, and fit into memory. A plane within 1 mm of the elements goes
/// to the direct sum, which computes points near an element in double precision.
std::optional<ShiftedGrid> worthwhile_shifts(const Array& array, const Grid& grid) {
    if (grid.x.size() < 8 || array.elements.size() < 4) return {};
    for (const double z : grid.z)
        if (!(std::abs(z - array.elements[0].position.z) >= 1e-3)) return {};
    auto shifted = find_shifts(array, grid);
    if (!shifted) return {};
    const std::size_t lattice = shifted->x.size() * shifted->y.size();
    const std::size_t waves = grid.x.size() * grid.y.size() * array.elements.size();
    if (lattice > most_lattice_points(grid) || lattice > waves / 2) return {};
    return shifted;
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
    const Sources sources(array, array.elements);
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

std::vector<std::complex<float>> pressure_at(const Array& array, Drives drives, std::span<const Vec3> points,
                                             const FieldOptions& options) {
    check(array, drives);
    std::vector<std::complex<float>> found(points.size());
    add_directly(array, drives, points, found, options);
    return found;
}

std::vector<std::complex<float>> pressure_on(const Array& array, Drives drives, const Grid& grid,
                                             const FieldOptions& options) {
    check(array, drives);
    std::vector<std::complex<float>> found(grid.size());
    if (const auto shifted = worthwhile_shifts(array, grid))
        add_shifted(array, drives, grid, *shifted, found, options);
    else
        add_directly(array, drives, grid, found, options);
    return found;
}

std::vector<float> mean_square_pressure_at(const Array& array, std::span<const WeightedDrives> sequence,
                                           std::span<const Vec3> points, const FieldOptions& options) {
    return mean_square(array, sequence, points, options);
}

std::vector<float> mean_square_pressure(const Array& array, std::span<const WeightedDrives> sequence, const Grid& grid,
                                        const FieldOptions& options) {
    return mean_square(array, sequence, grid, options);
}

}  // namespace haptogram
