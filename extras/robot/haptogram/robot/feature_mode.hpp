// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/hand/object.hpp"
#include "haptogram/hand/skin_line.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/robot/stimulus.hpp"

// Mode W1 of the paper Multimodal (section III): the ultrasound shows features of an object and where it meets the
// hand; the cables give weight, friction and texture.

namespace haptogram::fusion {

/// Where an object's edges and corners meet the plane of a hand's palm, laid onto the skin. The paper names the slice
/// plane; the two distances are ours.
struct SliceOptions {
    double corner_m = 5e-3;  ///< a corner as near to the plane as this meets it
    double skin_m = 10e-3;   ///< what is farther from all skin is beside the hand
};
/// @return places on the skin, array frame, metres: edges in their order, then corners
[[nodiscard]] std::vector<Vec3> slice_points(const TouchObject& object, const Hand& hand,
                                             const std::vector<SkinRegion>& skin, const SliceOptions& options = {});

/// Where a horizontal plane cuts the skin, as lines on it (mapping G1 of task T4).
/// @param height_m  of the plane above the array
[[nodiscard]] std::vector<SkinLine> plane_lines(const std::vector<SkinRegion>& skin, double height_m);

/// So many places along lines, each in the middle of its equal share of their whole length; none when there is none.
[[nodiscard]] std::vector<Vec3> spread(const std::vector<SkinLine>& lines, std::size_t count);

/// A horizontal surface that carries what is put on it. The paper names texture, weight and friction; the laws and the
/// values are ours.
struct Surface {
    double height_m = 0.0;        ///< in the frame of the position that is asked
    double stiffness_n_m = 1000;  ///< a virtual body of 1 kg and 30 ms takes less than 4444 N/m
    double friction = 0.4;        ///< tangential over normal force, while it slides
    double slow_m_s = 0.02;       ///< below it friction falls with speed, because the body's steps are long
    double texture = 0.3;         ///< largest tangential force of a cell over the normal force
    double cell_m = 10e-3;        ///< edge of a cell of the texture
};

/// The force of a surface on a body, N: zero above it; in it, normal force k·depth, friction against the motion, and a
/// texture of square cells that draw the body into their middles, −sin(2πx/cell) along x, and the same along y.
/// @param position, velocity  of the body, m and m/s
[[nodiscard]] robot::Vector3 surface_force(const Surface& surface, const robot::Vector3& position,
                                           const robot::Vector3& velocity);

/// Mode W1 as a whole: an object that the hand explores, and one that it carries over a surface.
/// @param weight_n   of what is carried
/// @param position, velocity  of the handle, in the frame of the surface
[[nodiscard]] Stimulus explore(const TouchObject& object, const Hand& hand, const std::vector<SkinRegion>& skin,
                               double weight_n, const Surface& surface, const robot::Vector3& position,
                               const robot::Vector3& velocity, const SliceOptions& options = {});

}  // namespace haptogram::fusion
