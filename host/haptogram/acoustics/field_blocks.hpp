// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "haptogram/acoustics/field.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/region.hpp"
#include "haptogram/acoustics/wave.hpp"

// What all ways to compute a field share: threads, and waves summed over blocks of points. Only the fields use it.

namespace haptogram {

/// How many threads a call uses. The limit is TBB's own, normally one thread a processor; asking for more would only
/// make TBB print a warning. The call reads this limit and never sets it, because it belongs to the whole process.
[[nodiscard]] unsigned workers(const FieldOptions& options);

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
struct BlockPoints {
    std::array<double, WaveBlock::most> x, y, z;
    std::size_t count = 0;
    Vec3 low, high;

    [[nodiscard]] Vec3 operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
};

/// Points are taken in blocks of WaveBlock::most; the last may have fewer.
[[nodiscard]] inline std::size_t blocks_of(std::size_t points) {
    return (points + WaveBlock::most - 1) / WaveBlock::most;
}

/// The points of a block of a list.
void take_block(std::span<const Vec3> from, std::size_t block, BlockPoints& points);

/// The same of a grid. Whole rows are copied, because Grid::point() for each point takes longer than the wave of one
/// element to it. Blocks hold the same points in the same order as if the grid's points had been listed.
void take_block(const Grid& from, std::size_t block, BlockPoints& points);

/// The elements that sound, what each of them plays, and how its wave spreads.
struct FieldSources {
    std::vector<Element> elements;
    std::vector<double> half_turns;  ///< phase of each drive, in units of π
    std::vector<float> amplitudes;
    WaveModel model;
    double half_turns_per_m = 0.0;

    /// @param pattern  of all elements, as fit_pattern() gives it
    FieldSources(const Array& array, std::vector<Element> at, const FittedPattern& pattern);
    void play(Drives drives);
    /// Makes all waves meet in phase everywhere: their sum is then the largest |p| that the drives, with any phases,
    /// could make.
    void align();
};

[[nodiscard]] FittedPattern fitted_pattern(const Array& array, const FieldOptions& options);
/// @throws Error{bad_input} unless there is a drive for each element
void require_drives(const Array& array, Drives drives);

/// A block of points and the elements around it, in single precision and relative to the block's centre.
class PreparedBlock {
public:
    WaveBlock block;
    std::vector<WaveElement> elements;
    std::vector<std::size_t> near_points;  ///< too near to an element for single precision, in ascending order

    /// @throws Error{bad_input} when a point coincides with an element
    void set(const FieldSources& sources, const BlockPoints& points);

private:
    void find_near(Vec3 element, const BlockPoints& points, double near_m);
};

/// Working memory of one thread.
struct FieldWorkplace {
    BlockPoints points;
    PreparedBlock prepared;
    alignas(64) std::array<float, WaveBlock::most> re, im;
};
[[nodiscard]] std::vector<std::unique_ptr<FieldWorkplace>> workplaces(unsigned workers);

/// Pressure at place.points, into place.re and place.im.
void sum_block(const Array& array, Drives drives, const FieldSources& sources, FieldWorkplace& place);

}  // namespace haptogram
