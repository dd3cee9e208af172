// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/hand/object.hpp"
#include "haptogram/hand/skin_line.hpp"
#include "haptogram/hand/surface.hpp"

namespace haptogram {

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
