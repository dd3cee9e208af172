// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/link/commands.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {

/// A device computes its foci for another speed of sound while this lives, which may change, and for that of its image
/// again when it goes.
class AirOn {
public:
    /// @param speed_m_s  of sound
    /// @param warn       told when the image's own could not be written back
    /// @throws Error{device} when the device computes no foci, or holds no image of foci
    AirOn(Commands& device, double speed_m_s, Warning warn = {});
    AirOn(const AirOn&) = delete;
    AirOn& operator=(const AirOn&) = delete;
    ~AirOn();

    void set(double speed_m_s);
    /// Of the image.
    [[nodiscard]] double own_speed_m_s() const { return own_speed_m_s_; }

private:
    void write(std::uint32_t wave_number);

    Commands& device_;
    Warning warn_;
    std::uint32_t own_ = 0;
    double carrier_hz_ = 0.0, own_speed_m_s_ = 0.0;
};

}  // namespace haptogram::link
