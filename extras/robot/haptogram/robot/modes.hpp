// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/hand/contour.hpp"
#include "haptogram/hand/hand.hpp"
#include "haptogram/hand/object.hpp"
#include "haptogram/hand/surface.hpp"
#include "haptogram/robot/geometry.hpp"

namespace haptogram::fusion {

/// What both stages give a hand for one period of the robot. A mapping makes it from a scene.
struct Stimulus {
    robot::Wrench wrench = robot::Wrench::Zero();  ///< of the scene on the handle's virtual body: N, N·m
    std::vector<Vec3> points;   ///< where one focus is in turn, array frame, metres; none: the ultrasound is silent
    double magnitude = 2.0;     ///< perceived, of each focus, in the unit of the perception tables
    double frequency_hz = 200;  ///< of the square wave that modulates them
};

/// The one clock of both stages. It counts carrier periods; a period of the robot is a whole number of them.
struct SharedClock {
    double carrier_hz = 40000.0;
    std::uint32_t carrier_periods = 1200;  ///< in a period of the robot: 30 ms, 33.3 Hz (Multimodal, section II-C)
    [[nodiscard]] double period_s() const { return carrier_periods / carrier_hz; }
};

/// The clock of a robot and a carrier. @param period_s  of the robot
/// @throws Error{bad_argument} naming "period" unless a period of the robot is a whole number of carrier periods
[[nodiscard]] SharedClock shared_clock(double period_s, double carrier_hz);

}  // namespace haptogram::fusion

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

// Mode W2 of the paper Multimodal (section III): the cables give the weight; a pattern on the palm says by its
// intensity, its frequency or a transformation how far, how hard or how rough something is.

namespace haptogram::fusion {

/// What of the pattern tells the value.
enum class PalmSign { intensity, frequency, translation, rotation, scaling };
/// "intensity", "frequency", "translation", "rotation" or "scaling". @throws Error{bad_argument} naming "sign"
[[nodiscard]] PalmSign palm_sign(const std::string& name);

/// What a sign is for the values 0 and 1 unless the user says otherwise, in the units of PalmPattern. Ours.
struct SignRange {
    double low, high;
};
[[nodiscard]] SignRange usual_range(PalmSign sign);

enum class PalmShape { focus, line, ring };
/// "focus", "line" or "ring". @throws Error{bad_argument} naming "pattern"
[[nodiscard]] PalmShape palm_shape(const std::string& name);

/// A pattern on the palm. The paper names the signs; the measures and ranges are ours. `low` and `high` are what the
/// sign is for the values 0 and 1, linear between them.
struct PalmPattern {
    PalmSign sign = PalmSign::frequency;
    PalmShape shape = PalmShape::focus;
    double low = 80.0, high = 300.0;  ///< magnitude, Hz, metres along the hand, degrees to the left, or a factor
    double magnitude = 2.0;           ///< perceived, unless it is the sign
    double frequency_hz = 200.0;      ///< unless it is the sign
    double size_m = 20e-3;            ///< length of the line, diameter of the ring
};

/// The pattern that tells a value.
/// @param value   0…1
/// @param points  of a line or a ring, at least 2; a focus is one
/// @throws Error{bad_argument} naming "value" outside of 0…1, and what of the pattern makes no sense: a sign that its
/// shape does not show (a focus does not turn or grow, a ring does not turn)
[[nodiscard]] Stimulus tell(const PalmPattern& pattern, double value, const Hand& palm, std::size_t points = 1);

/// Values for tell(). Nearness is 1 at the target and falls linearly to 0 at `range_m` and beyond.
[[nodiscard]] double nearness(double distance_m, double range_m);
/// Roughness of a cloth whose threads cross every `cell_m`: ½ + ½·sin(2πx/cell)·sin(2πy/cell).
[[nodiscard]] double cloth(double x_m, double y_m, double cell_m);
/// Hardness of a spring between the softest and the hardest that are told, by the logarithm of its stiffness.
/// @throws Error{bad_argument} naming "stiffness" outside of them
[[nodiscard]] double hardness(double stiffness_n_m, double softest_n_m, double hardest_n_m);

}  // namespace haptogram::fusion
