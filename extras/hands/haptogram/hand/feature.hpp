// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "haptogram/hand/contour.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/surface.hpp"

namespace haptogram {

/// Random numbers from a key of whole numbers, the same on every machine: splitmix64 (Steele, Lea and Flood 2014).
class KeyedRandom {
public:
    KeyedRandom(std::initializer_list<std::int64_t> key) {
        for (const std::int64_t part : key) {
            state_ ^= static_cast<std::uint64_t>(part);
            state_ = next();
        }
    }

    /// In [low, high).
    double uniform(double low, double high) {
        return low + (high - low) * static_cast<double>(next() >> 11U) * 0x1p-53;
    }

private:
    std::uint64_t next() {
        std::uint64_t mixed = state_ += 0x9e3779b97f4a7c15U;
        mixed = (mixed ^ (mixed >> 30U)) * 0xbf58476d1ce4e5b9U;
        mixed = (mixed ^ (mixed >> 27U)) * 0x94d049bb133111ebU;
        return mixed ^ (mixed >> 31U);
    }

    std::uint64_t state_ = 0;
};

/// Random numbers of simulated sensors, the same on every machine. Not installed: no public header includes it.
class Noise {
public:
    explicit Noise(std::uint64_t seed) : generator_(seed) {}
    /// Normal, of standard deviation 1 (Box and Muller's transform).
    double normal() {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
        return radius * std::cos(2.0 * std::numbers::pi * uniform());
    }
    /// From 0 to less than 1.
    double uniform() { return static_cast<double>(generator_() >> 11U) * 0x1p-53; }

private:
    std::mt19937_64 generator_;
};

/// Short random lines on the skin inside an object. The paper names them; their measures are ours.
struct GrainOptions {
    double spacing_m = 6e-3;  ///< a line for each square, or each cube, of this edge
    double length_m = 4e-3;
    std::size_t points = 5;  ///< of a line
    std::uint64_t seed = 1;
};

/// Other lines at every time (Shapes, algorithm E): each square of the raster whose middle is inside gets a line, which
/// begins at a random place of the square and turns at random, as far as the raster goes.
[[nodiscard]] std::vector<SkinLine> random_grain(const SkinRegion& region, const DepthMap& map, double time_s,
                                                 std::size_t number, const GrainOptions& options);

/// Lines that stay where they are in space (Shapes, algorithm F): each cube of a lattice in which the skin is inside
/// gets a line in the cube that only depends on the cube and the seed, laid onto the skin. A hand that does not move
/// feels the same lines again.
[[nodiscard]] std::vector<SkinLine> fixed_grain(const SkinRegion& region, const DepthMap& map, std::size_t number,
                                                const GrainOptions& options);

/// What is drawn where a corner of the object meets the hand (Shapes, algorithm B).
enum class CornerFigure { circle, pulsing, line, triangle, points };
/// The figure of a name: circle, pulsing-circle, rotating-line, triangle or random-points.
/// @throws Error{bad_argument} for another name
[[nodiscard]] CornerFigure corner_figure(const std::string& name);

/// The paper names the figures; their measures are ours.
struct FeatureOptions {
    CornerFigure corner = CornerFigure::line;  ///< which Shapes found to be felt most strongly
    bool project = true;                       ///< draw on the skin, not where the object has its edge
    double radius_m = 5e-3;                    ///< of the circles and of the disc of random points
    double pulse_share = 0.5;                  ///< by which the pulsing circle's radius swings
    double pulse_hz = 5.0;
    double line_m = 10e-3;  ///< length of the rotating line
    double turns_hz = 20.0;
    double triangle_m = 10e-3;  ///< its sides
    std::size_t points = 8;     ///< random points, other ones at every time
    std::uint64_t seed = 1;     ///< of them
    double step_m = 1e-3;       ///< between points of an edge that is laid onto the skin
};

/// Edges and corners of the object where they are inside the boxes around the phalanges and the palm (Shapes, section
/// IV-B). Where boxes overlap, an edge counts for the first one; a corner counts for the region whose skin is nearest.
/// @param time_s  since the beginning, for figures that move
[[nodiscard]] std::vector<SkinLine> feature_lines(const TouchObject& object, const std::vector<SkinRegion>& skin,
                                                  double time_s, const FeatureOptions& options);

/// A circle around a place on the skin, in the plane that touches it there.
[[nodiscard]] SkinLine skin_circle(const SkinPoint& centre, double radius, LineKind kind, std::size_t region);

}  // namespace haptogram
