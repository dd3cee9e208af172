// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/array/array.hpp"
#include "haptogram/perception/tables.hpp"
#include "haptogram/perception/threshold.hpp"
#include "haptogram/perception/waveform.hpp"

namespace haptogram::perception {

/// How a focus shall feel.
struct Wanted {
    double magnitude = 2.0;  ///< perceived, in the unit of the tables
    double frequency_hz = 200.0;
    Region region = Region::palm;
    double grip_n = 1.0;  ///< the force that the hand holds at the same time
    Waveform waveform = Waveform::square;
    double duty = 0.5;  ///< of the square wave
    Weighing weighing = Weighing::fundamental;
};

/// What makes it feel so.
struct Setting {
    double output_gf = 0.0;  ///< gs: what is felt so under a square wave of 50 % duty (inverse of Multimodal eq. 10)
    double least_felt_gf = 0.0;  ///< the threshold below which nothing is promised
    double waveform_factor = 1.0, duty_factor = 1.0, position_factor = 1.0;
    double factor = 1.0;      ///< F_I of Multimodal eq. 12: all three together
    double needed_gf = 0.0;   ///< gF = gs·F_I (Multimodal eq. 11)
    double full_gf = 0.0;     ///< what the device gives at its full command
    double command = 0.0;     ///< 0…1
    double pulse_duty = 0.0;  ///< of the carrier period: how long the pulse of that command is
};

/// F_pl·F_H of Multimodal eq. 13, from physics: the full force at `reference`, where the tables were measured, over
/// that at `focus`. It is below 1 where the array is stronger than at the reference. Errors as above.
[[nodiscard]] double position_factor(const Array& array, Vec3 focus, Vec3 reference = {0.0, 0.0, 0.2});

/// How long a pulse is whose carrier has `amplitude` times that of a pulse of `full_duty`, as a part of the carrier
/// period: asin(amplitude·sin(π·full_duty))/π (Hoshi eq. 7, solved for the pulse).
/// @throws Error{bad_argument} naming "amplitude" outside of 0…1
[[nodiscard]] double pulse_duty(double amplitude, double full_duty = 0.5);

/// The output that is needed for it where the device's place costs nothing: gs over the factor of the waveform, gf.
/// @throws Error{bad_argument} as setting_for(), of what does not depend on the device
[[nodiscard]] double needed_gf(const Tables& tables, const Wanted& wanted);

/// The setting of the device that the tables were measured on, with its focus where they were measured.
/// Its command is the polynomial's (Multimodal eq. 11). The pulse is that of an amplitude equal to the command.
/// @throws Error{bad_argument} naming what lies outside of what was measured: a magnitude below the threshold, or above
/// what the full command makes. Nothing is extrapolated. Also for a finger, because the magnitudes are those of palms
[[nodiscard]] Setting setting_for(const Tables& tables, const Wanted& wanted);

/// The same for a focus of an array, from physics: the command is the amplitude of the drive, the root of the needed
/// force over the array's full one.
/// @throws Error{bad_input} naming "focus" when it cannot be reached, and {bad_argument} naming "magnitude" when the
/// array is too weak there
[[nodiscard]] Setting setting_for(const Tables& tables, const Wanted& wanted, const Array& array, Vec3 focus);

}  // namespace haptogram::perception
