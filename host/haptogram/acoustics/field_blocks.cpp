// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/field_blocks.hpp"

#include <fmt/core.h>
#include <tbb/global_control.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

constexpr double coincident_m = 1e-9;  ///< a point nearer than this to an element counts as being on it

std::size_t end_of_block(std::size_t block, std::size_t points) {
    return std::min(points, (block + 1) * WaveBlock::most);
}

}  // namespace

unsigned workers(const FieldOptions& options) {
    const auto most =
        static_cast<unsigned>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    return options.threads == 0 ? most : std::min(options.threads, most);
}

void take_block(std::span<const Vec3> from, std::size_t block, BlockPoints& points) {
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

void take_block(const Grid& from, std::size_t block, BlockPoints& points) {
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

FieldSources::FieldSources(const Array& array, std::vector<Element> at, const FittedPattern& pattern)
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

void FieldSources::play(Drives drives) {
    for (std::size_t m = 0; m < elements.size(); ++m) {
        const std::complex<double> radiated = drives[m] * elements[m].response;
        half_turns[m] = std::arg(radiated) / std::numbers::pi;
        amplitudes[m] = static_cast<float>(std::abs(radiated));
    }
}

void FieldSources::align() {
    std::fill(half_turns.begin(), half_turns.end(), 0.0);
    half_turns_per_m = 0.0;
    model.half_turns_per_m = 0.0F;
}

FittedPattern fitted_pattern(const Array& array, const FieldOptions& options) {
    return fit_pattern(array.transducer, 2.0 * std::numbers::pi / array.wavelength_m(), options.pattern_error);
}

void require_drives(const Array& array, Drives drives) {
    if (drives.size() != array.elements.size())
        throw bad_input("field", fmt::format("found {} drives for {} elements; expected one each", drives.size(),
                                             array.elements.size()));
}

void PreparedBlock::set(const FieldSources& sources, const BlockPoints& points) {
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

void PreparedBlock::find_near(Vec3 element, const BlockPoints& points, double near_m) {
    for (std::size_t i = 0; i < points.count; ++i) {
        const Vec3 ray = points[i] - element;
        const double square = dot(ray, ray);
        if (square >= near_m * near_m) continue;
        if (square < coincident_m * coincident_m) throw coincidence();
        near_points.push_back(i);
    }
}

std::vector<std::unique_ptr<FieldWorkplace>> workplaces(unsigned workers) {
    std::vector<std::unique_ptr<FieldWorkplace>> places(workers);
    for (auto& place : places) place = std::make_unique<FieldWorkplace>();
    return places;
}

void sum_block(const Array& array, Drives drives, const FieldSources& sources, FieldWorkplace& place) {
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

}  // namespace haptogram
