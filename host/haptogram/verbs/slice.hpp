// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/verbs/excitation.hpp"

namespace haptogram {

/// A flat patch of points in any direction. Point (i, j) is origin + u·i/(width − 1) + v·j/(height − 1).
struct Slice {
    Vec3 origin;                          ///< a corner, metres
    Vec3 u, v;                            ///< the edges that begin there, metres
    std::uint32_t width = 0, height = 0;  ///< points along u and along v

    [[nodiscard]] std::size_t size() const { return std::size_t{width} * height; }
};

inline constexpr std::uint32_t most_slice_points = 2048;  ///< along an edge
inline constexpr std::size_t most_skin_points = 20'000;   ///< places on a skin, or anywhere else
inline constexpr double most_slice_terms = 1e10;          ///< elements × sets of drives × points

/// Mean square of the sound pressure at a slice's points, Pa²: rows along u, v = 0 first. Radiation pressure, rms
/// pressure and level follow from it by a factor or a logarithm, so that a view changes its unit without a new
/// calculation. The same numbers as field() gives for Quantity::rms, squared. Slices along the axes are the fastest.
/// @param threads  0: as many as there are processors; the result is the same, byte by byte, for any number
/// @throws Error{bad_argument} for a slice that has fewer than 2 or more than most_slice_points along an edge, whose
/// corner or edges are not finite, or that takes more than most_slice_terms; and as mean_square_pressure_at()
[[nodiscard]] std::vector<float> mean_square_on(const Excitation& excitation, const Slice& slice, unsigned threads = 1,
                                                const Progress& progress = {});

/// The same at places anywhere, one to most_skin_points.
[[nodiscard]] std::vector<float> mean_square_at(const Excitation& excitation, std::span<const Vec3> points);

/// The same of a focus that the array makes at each point in turn: what it can do where. 0 out of its reach.
/// @throws Error as mean_square_on(), of one set of drives
[[nodiscard]] std::vector<float> reachable_on(const Array& array, const Slice& slice);

}  // namespace haptogram
