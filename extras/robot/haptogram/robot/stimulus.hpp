// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/robot/geometry.hpp"

namespace haptogram::fusion {

/// What both stages give a hand for one period of the robot. A mapping makes it from a scene.
struct Stimulus {
    robot::Wrench wrench = robot::Wrench::Zero();  ///< of the scene on the handle's virtual body: N, N·m
    std::vector<Vec3> points;   ///< where one focus is in turn, array frame, metres; none: the ultrasound is silent
    double magnitude = 2.0;     ///< perceived, of each focus, in the unit of the perception tables
    double frequency_hz = 200;  ///< of the square wave that modulates them
};

/// The one clock of both stages. It counts carrier periods; every so many of them, the robot has one of its own.
struct SharedClock {
    double carrier_hz = 40000.0;
    std::uint32_t carrier_periods = 1200;  ///< in a period of the robot: 30 ms, 33.3 Hz (Multimodal, section II-C)
    [[nodiscard]] double period_s() const { return carrier_periods / carrier_hz; }
};

/// The clock of a robot and a carrier. @param period_s  of the robot
/// @throws Error{bad_argument} naming "period" unless a period of the robot is a whole number of carrier periods
[[nodiscard]] SharedClock shared_clock(double period_s, double carrier_hz);

}  // namespace haptogram::fusion
