// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <numbers>

#include "haptogram/robot/geometry.hpp"

namespace haptogram::robot {

/// What the drives are made of (Multimodal section II-C). Where the paper gives no value the default is ours.
struct DriveOptions {
    double gear = 4.4;           ///< motor turns a pulley turn
    double pulley_m = 0.020;     ///< diameter
    int encoder_pulses = 500;    ///< a motor turn; each pulse gives four counts
    int converter_bits = 12;     ///< of the torque command, one of them the sign
    double full_scale_n = 20.0;  ///< pull at the largest code; ours, twice the largest tension

    /// Cable length of one encoder count, m.
    [[nodiscard]] double metres_per_count() const {
        return std::numbers::pi * pulley_m / (gear * 4.0 * encoder_pulses);
    }
    [[nodiscard]] int largest_code() const { return (1 << (converter_bits - 1)) - 1; }
    /// Pull of one code, N.
    [[nodiscard]] double newtons_per_code() const { return full_scale_n / largest_code(); }
};

/// What one drive tells.
struct DriveReading {
    std::int32_t counts = 0;    ///< encoder, growing while cable is let out, 0 where the robot was switched on
    double tension_n = 0.0;     ///< force sensor at the handle
    bool tension_valid = true;  ///< false when the sensor does not answer
};

/// The eight drives, as a driver for their bus has them. The simulated plant is one.
class CableDrives {
public:
    virtual ~CableDrives() = default;
    /// Torque commands: positive codes pull. @throws Error{bad_argument} for codes beyond largest_code(), Error{device}
    /// when the bus fails
    virtual void command(const std::array<std::int16_t, cable_count>& codes) = 0;
    /// The latest readings. @throws Error{device} when the bus fails
    [[nodiscard]] virtual std::array<DriveReading, cable_count> read() = 0;
};

}  // namespace haptogram::robot
