// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "haptogram/base/progress.hpp"
#include "haptogram/robot/modes.hpp"
#include "haptogram/robot/scenes.hpp"

// Task T4 of the paper Multimodal: carry a virtual cube to a height that only touch tells.

namespace haptogram::fusion {

/// How the height is told.
enum class Mapping {
    plane,      ///< G1, mode W1: a horizontal plane at the height; where it cuts the hand is felt
    frequency,  ///< G2, mode W2: a focus on the palm whose frequency rises as the cube comes near
    magnitude,  ///< G3, mode W2: a focus on the palm that is felt more strongly as the cube comes near
};
/// "G1", "G2" or "G3". @throws Error{bad_argument} naming "mapping"
[[nodiscard]] Mapping mapping_of(const std::string& name);
[[nodiscard]] std::string name_of(Mapping mapping);

/// A scripted user, who shows that the loop works. It is no model of people: nothing about them follows from it.
/// The hand goes down until the cue is clearly past its best, up until it is so again, then to the middle of both
/// heights, and stays. All values are ours.
struct PlacingUser {
    robot::Impedance hand;          ///< between the hand and where it wants to be
    double speed_m_s = 0.03;        ///< of where it wants to be
    double least_change = 0.1;      ///< of a frequency or a magnitude, as a part of it, that is noticed
    double least_shift_m = 8.5e-3;  ///< of a line on the palm that is noticed: about the width of a focus
    double steady_m = 0.5e-3;       ///< it stays this near to the middle
    double steady_s = 1.0;          ///< for so long before it says that the cube is placed
    double search_m = 0.12;         ///< it gives up so far below its start
};

/// The paper gives the height, the weight and what the mappings are. All other values are ours.
struct PlaceOptions {
    Mapping mapping = Mapping::plane;
    double target_m = 0.25, start_m = 0.30;  ///< heights of the cube above the array
    double weight_n = 1.0;
    double range_m = 0.1;                              ///< of G2 and G3: farther away the cue does not change
    double magnitude = 2.0;                            ///< of G1 and G2
    double plane_hz = 200.0;                           ///< of G1
    double low_hz = 80.0, high_hz = 300.0;             ///< of G2
    double low_magnitude = 1.0, high_magnitude = 4.0;  ///< of G3
    double magnitude_hz = 240.0;                       ///< of G3: where magnitudes from 1 to 4 are known and felt
    double tilt_deg = 20.0;                            ///< of the hand in G1, fingers down
    Vec3 robot_centre{0.0, 0.0, 0.25};                 ///< of the robot's frame, in the array's
    robot::Geometry geometry;
    robot::PlantOptions plant;
    robot::ControllerOptions controller;  ///< its zones have no springs in this task
    PlacingUser user;
    double longest_s = 30.0;  ///< after which the run ends, placed or not
};

/// What was in one period of the robot.
struct PlaceRow {
    double time_s = 0.0;           ///< at the period's end, when all that follows was
    double height_m = 0.0;         ///< of the cube
    double wanted_m = 0.0;         ///< where the hand wants it
    double frequency_hz = 0.0;     ///< that was asked for; 0 when nothing was felt
    double magnitude = 0.0;        ///< the same
    std::optional<double> line_m;  ///< of G1: how far along the palm the plane cuts it, towards the fingers
    double scene_n = 0.0;          ///< vertical force of the scene on the handle
    double user_n = 0.0;           ///< vertical force of the user on the handle
    double measured_n = 0.0;       ///< what the controller takes it for
};

struct Placed {
    bool placed = false;                                        ///< the user said so
    double time_s = 0.0;                                        ///< until then
    double error_m = std::numeric_limits<double>::quiet_NaN();  ///< height when it was placed, less the target
    double weight_n = 0.0;    ///< mean force with which the user held the cube at rest
    double measured_n = 0.0;  ///< the same by the controller
    std::vector<PlaceRow> rows;
    std::vector<Frame> frames;  ///< one a row
    std::vector<robot::Event> events;
    double least_tension_n = 0.0;
    std::size_t points = 0, silent = 0;  ///< of all frames: foci that were asked for, and that the array cannot make
    std::string why;                     ///< of the first of these
};

/// Plays the task: scripted user, simulated robot, and what the array shall play meanwhile, on one clock. The same
/// options give the same result.
/// @param clock  its period must be that of the controller's admittance
/// @throws Error{bad_argument} naming what makes no sense, and where the handle cannot start
[[nodiscard]] Placed place_cube(const PlaceOptions& options, const Array& array, const perception::Tables& tables,
                                const SharedClock& clock, const Progress& progress = {});

/// An open right hand, palm down, fingers along y and `tilt` below the horizontal. @param palm  its centre, array frame
[[nodiscard]] Hand open_hand(Vec3 palm, double tilt_deg);

/// A row a period: time_s, height_mm, wanted_mm, frequency_hz, magnitude, line_mm (empty when there is none),
/// scene_n, user_n, measured_n.
[[nodiscard]] std::string to_csv(const Placed& placed);

}  // namespace haptogram::fusion
