// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "haptogram/array/array.hpp"

namespace haptogram {

/// Measured devices made about so much less force than nominal source strengths say, least and most: Hoshi et al. 2010
/// measured 16 of 134 mN on a disc of 20 mm, and the paper “Multimodal” 0.540 of 5.15 gf (docs/references.md).
inline constexpr double nominal_excess_least = 8.0, nominal_excess_most = 10.0;

/// What an array's absolute pressures and forces rest on, in a sentence: how its source strength was measured, or that
/// it is nominal, and by how much measured devices fell short of that.
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
