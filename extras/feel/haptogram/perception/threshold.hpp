// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "haptogram/perception/tables.hpp"

namespace haptogram::perception {

/// Where on the hand.
enum class Region { palm, finger };

/// "palm" or "finger". @throws Error{bad_argument} naming "region" for anything else
[[nodiscard]] Region region_of(const std::string& name);

/// The interval of the least that is felt, while the hand holds a handle that pulls with `grip_n` newtons. Between two
/// rows of the tables both ends are interpolated linearly in the logarithm of the force.
/// @throws Error{bad_argument} naming "grip" outside of the tables' forces. A bare hand is not in them; it feels less
/// than one that holds 1 N, so the values of 1 N are an upper bound for it
[[nodiscard]] Interval threshold_interval(const Tables& tables, Region region, double grip_n);

/// The least that is felt at a frequency, gf. The tables have intervals without saying which frequency gave which end.
/// Ours: the low end in the band that is called the most sensitive, the high end at the tables' lowest and highest
/// frequency, and between them linear in the logarithm of the frequency.
/// @throws Error{bad_argument} as threshold_interval() and fit_at()
[[nodiscard]] double least_felt_gf(const Tables& tables, Region region, double frequency_hz, double grip_n);

/// a + b·ln F, the line of least squares through the centres of the tables' intervals: gf over grip force F in N.
struct ThresholdLaw {
    double a_gf = 0.0, b_gf = 0.0;
    double largest_residual_gf = 0.0;
};
[[nodiscard]] ThresholdLaw threshold_law(const Tables& tables, Region region);

inline constexpr double lowest_vibration_hz = 10.0, highest_vibration_hz = 1000.0;

/// The least vibration of the skin that is felt, dB re 1 µm of displacement (peak): the lower one of two channels, with
/// a large contactor on glabrous skin (Gescheider and Verrillo). The Pacinian channel is −20 dB at 250 Hz, falls by 12
/// dB an octave up to there, and rises by 12 dB an octave above 300 Hz; the other channel is flat, +12.5 dB, up to 40
/// Hz, and has no value above. Levels are textbook values, good to ± 5 dB. Measurements end near 700 Hz; the rise is
/// carried on to 1 kHz, which is as fast as devices modulate.
/// @param frequency_hz  from lowest_vibration_hz to highest_vibration_hz
/// @param area_factor   contact area over that of the textbook values; a doubling makes the Pacinian channel 3 dB
/// better
/// @throws Error{bad_argument} outside of these
[[nodiscard]] double least_displacement_db(double frequency_hz, double area_factor = 1.0);

}  // namespace haptogram::perception
