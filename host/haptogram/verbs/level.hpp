// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "haptogram/array/array.hpp"

namespace haptogram {

/// A whole array made so much of the pressure that its transducers' data sheet promises for the same voltage. Hoshi et
/// al. 2010 weighed 16 of 134 mN with 24 V between the peaks, 10.8 V rms of the carrier: √(16/134)/1.08 = 0.320. The
/// paper “Multimodal” weighed 0.540 of 5.15 gf, which is √(0.540/5.15) = 0.324 if its device has 10 V rms, which it
/// does not say (docs/references.md).
inline constexpr double share_of_data_sheet = 0.322;
/// Between 8 and 10 times less force than the data sheet's was weighed: a decibel to each side, of forces (20·lg).
inline constexpr double share_known_to_db = 1.0;

/// The source strength that an element of an array is expected to have, and how much less and more force that may be.
struct ExpectedLevel {
    double source_pa_m = 0.0;
    double less_db = 0.0, more_db = 0.0;  ///< of forces
    std::string text;                     ///< a sentence
};

/// A measured level is taken as it is. Where an array file has a shipped transducer's nominal strength, it is
/// `share_of_data_sheet` of the data sheet's, at the drivers' supply. Any other number is taken as the file says it,
/// and may be a data sheet's.
/// @param supply_v  of the drivers, which is what their square wave swings over; by default 20 V for a MA40S4S (the
/// paper, III-D) and 24 V for a T4010A1 (Hoshi 3.1)
/// @throws Error{bad_argument} naming "volts" when it is not positive, or the transducer is not one of these
[[nodiscard]] ExpectedLevel expected_level(const Transducer& transducer, std::optional<double> supply_v = {});

/// What an array's absolute pressures and forces rest on, in a sentence: how its source strength was measured, or that
/// it is nominal, and what is expected instead.
[[nodiscard]] std::string level_text(const Transducer& transducer);

/// The same for programs: calibrated, source_pa_m, note.
[[nodiscard]] nlohmann::ordered_json level_json(const Transducer& transducer);

/// A level that was measured, and how.
struct MeasuredLevel {
    double source_pa_m = 0.0;
    std::string measured;
};

/// What was measured of a steady focus at full drive: one of the two.
struct LevelReading {
    std::optional<double> force_n;  ///< on a disc as steady_force() has it
    std::optional<double> rms_pa;   ///< by a microphone at the focus
};

/// The rms pressure that a microphone's rms voltage means. Its sensitivity is that at the carrier.
/// @throws Error{bad_argument} when either is not positive
[[nodiscard]] double microphone_pa(double rms_mv, double mv_a_pa);

/// The source strength with which the computed force or pressure is the measured one.
/// @throws Error{bad_argument} when the reading is not positive, or the array cannot reach the focus
[[nodiscard]] MeasuredLevel measured_level(const Array& array, Vec3 focus, const LevelReading& reading);
/// The same as keys of an array file.
[[nodiscard]] std::string calibrated_keys(const Array& array, Vec3 focus, const LevelReading& reading);

}  // namespace haptogram
