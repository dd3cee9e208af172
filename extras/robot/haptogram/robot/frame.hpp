// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/perception/setting.hpp"
#include "haptogram/robot/stimulus.hpp"

namespace haptogram::fusion {

/// A focus of a frame, and what makes it feel as it shall.
struct FramePoint {
    Vec3 position;  ///< array frame, metres
    perception::Setting setting;
};

/// What the ultrasound plays in one period of the robot.
struct Frame {
    Path path;  ///< exactly as long as the period; the modulation is in its steps
    double magnitude = 0.0, frequency_hz = 0.0;
    std::vector<FramePoint> points;  ///< that are played
    std::size_t silent = 0;          ///< points that the array cannot make at that magnitude; they stay silent
    std::string why;                 ///< of the first of these
};

/// How many points a period of the robot has time for at a frequency: whole periods of the square wave, at least one.
[[nodiscard]] std::size_t places_of(const SharedClock& clock, double frequency_hz);

/// Turns stimuli into frames. The square wave of 50 % duty goes on from frame to frame without a jump of its phase, at
/// whatever frequency each asks for; its edges lie on the nearest carrier period. A focus rests for a whole period of
/// the square wave, then the next point has its turn, because the magnitudes were measured with a focus that rests.
class FramePen {
public:
    /// @param grip_n  force that the hand holds, for the threshold
    FramePen(const Array& array, const perception::Tables& tables, const SharedClock& clock, double grip_n = 1.0)
        : array_(array), tables_(tables), clock_(clock), grip_n_(grip_n) {}

    /// How many points a frame has time for at a frequency.
    [[nodiscard]] std::size_t places(double frequency_hz) const { return places_of(clock_, frequency_hz); }

    /// @throws Error{bad_argument} naming "magnitude" or "frequency" when the tables do not know them, or "points" when
    /// there are more than places()
    [[nodiscard]] Frame play(const Stimulus& stimulus);

private:
    const Array& array_;
    const perception::Tables& tables_;
    SharedClock clock_;
    double grip_n_;
    double phase_ = 0.0;  ///< of the square wave when the next frame begins, in its periods, 0…1
};

/// How strong a point is felt when the carrier at the pins has another amplitude than was asked for.
/// @param command  that was measured, as a fraction of full drive
/// @throws Error{bad_argument} naming "output" when the tables do not know so strong a focus
[[nodiscard]] double magnitude_of(const perception::Tables& tables, double frequency_hz, const FramePoint& point,
                                  double command);

}  // namespace haptogram::fusion
