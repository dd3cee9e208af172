// SPDX-License-Identifier: Apache-2.0
// Coarse grids from which a field on a finer grid is interpolated: a part of field.hpp.
//
// Seen from far enough, a sound field changes along a line no faster than its waves do: by k·cos γ, where γ is the
// angle between a wave and the line. A field whose changes have such a bound follows from its values at evenly spaced
// points, and a few of them on either side are enough when they are spaced somewhat closer than the bound asks.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "haptogram/acoustics/region.hpp"
#include "haptogram/array/array.hpp"

namespace haptogram {

/// How many values of a coarse axis one interpolated value is made of, on either side half of them.
inline constexpr std::size_t interpolation_taps = 12;

/// The coordinates along one axis of a grid, and the evenly spaced ones from which a field at them is interpolated. An
/// axis may also be kept as it is; then each value is made of one.
struct CoarseAxis {
    std::vector<double> coarse;  ///< metres
    std::size_t taps = 1;        ///< 1 for an axis that is kept, or interpolation_taps
    /// Of each wanted coordinate the first coarse one that it is made of; never falls. Behind its end it goes on with
    /// the last value, for vectors that reach beyond.
    std::vector<std::int32_t> first;
    /// Weights, complex and in two lists. The one of a coordinate's tap t is at t · stride + coordinate; beyond the
    /// last coordinate they are 0.
    std::vector<float> re, im;
    std::size_t size = 0, stride = 0;

    [[nodiscard]] bool kept() const { return taps == 1; }
};

/// The part of an axis for its wanted coordinates from `begin` to before `end`.
[[nodiscard]] CoarseAxis part_of(const CoarseAxis& axis, std::size_t begin, std::size_t end);

struct CoarseGrid {
    CoarseAxis x, y, z;
    [[nodiscard]] Grid grid() const { return {x.coarse, y.coarse, z.coarse}; }
};

/// Local wave numbers along an axis, rad/m: what a field's phase may change by along it.
struct Band {
    double low = 0.0, high = 0.0;
};

/// The axis as it is.
[[nodiscard]] CoarseAxis kept_axis(const std::vector<double>& axis);

/// A coarse axis with the step `step_m` and one coordinate at `origin_m`, for coordinates that rise evenly by less than
/// this step. Values whose phase along the axis changes within the band come out to 4e-5, if half of the band's width
/// times the step is at most widest_band.
[[nodiscard]] CoarseAxis interpolated_axis(const std::vector<double>& axis, Band band, double step_m, double origin_m);
inline constexpr double widest_band = 1.55;  ///< radians in one coarse step

/// The coarse grid that suits the waves of these elements; nothing when no axis of the grid is worth interpolating, or
/// the grid is within two and a half wavelengths of an element. Its steps divide the array's pitch if the array is a
/// grid, so that shift.hpp can be used on it.
[[nodiscard]] std::optional<CoarseGrid> find_coarse_grid(const Array& array, const Grid& grid);

}  // namespace haptogram
