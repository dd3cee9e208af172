// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "haptogram/format/core.hpp"
#include "haptogram/robot/scenes.hpp"

namespace haptogram::cli {

/// What the pins of the simulated board made of a frame.
struct PinsOfFrame {
    double frequency_hz = 0.0;  ///< of the bursts
    struct Point {
        Vec3 position;           ///< metres
        double asked = 0.0;      ///< command
        double measured = 0.0;   ///< pressure at the focus by the pins' pulses, over that of full drive
        double magnitude = 0.0;  ///< that the measured command is felt with
        double ticks_off = 0.0;  ///< of the pulses' length; half a tick is what rounding may do
    };
    std::vector<Point> points;
    std::size_t pulses = 0;               ///< that were compared with the image, clock by clock
    std::vector<std::string> violations;  ///< of the core's contracts
};

/// Compiles a frame, plays it on the simulated board, and measures the pins.
/// @throws Error{bad_input} when no Verilated core can play it, Error{bad_argument} in a build without them
[[nodiscard]] PinsOfFrame pins_of(const fusion::Frame& frame, const Array& array, const Core& core,
                                  const perception::Tables& tables);

}  // namespace haptogram::cli
