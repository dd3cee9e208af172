// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace haptogram::perception {

/// The forces of a focus are kept in gram-force (gf), the unit of the printed tables: 1 gf = 9.80665 mN.
inline constexpr double gram_force_n = 9.80665e-3;

/// Polynomials that were fitted at one frequency of modulation. g is the output of a focus in gf, under a square wave
/// of 50 % duty.
struct FrequencyFit {
    double frequency_hz = 0.0;
    std::array<double, 4> command{};    ///< L, M, N, U of I = L·g³ + M·g² + N·g + U (Multimodal eq. 11)
    std::array<double, 3> magnitude{};  ///< G, J, V of PI = G·g² + J·g + V, for the palm (Multimodal eq. 10)
    double command_r2 = 0.0, magnitude_r2 = 0.0;  ///< how well each fitted, as printed
};

/// The least that was felt, from … to, gf.
struct Interval {
    double low_gf = 0.0, high_gf = 0.0;
    [[nodiscard]] double centre_gf() const { return (low_gf + high_gf) / 2.0; }
};

/// Thresholds while the hand held a handle that pulled with this force.
struct ThresholdRow {
    double grip_n = 0.0;
    Interval palm, finger;
};

/// What is known of how strong a focus feels, as a perception file has it.
struct Tables {
    std::string name, file, source;
    std::vector<FrequencyFit> fits;        ///< two or more, frequencies rising
    std::vector<ThresholdRow> thresholds;  ///< two or more, grip forces rising
    double most_sensitive_from_hz = 0.0, most_sensitive_to_hz = 0.0;
};

/// Reads a perception file (TOML); extras/feel/README.md describes its keys.
/// @throws Error{bad_input} naming file, line and key; also when a polynomial does not rise where it is used, from 0 gf
/// to the output of the full command, because it could not be inverted then
[[nodiscard]] Tables load_tables(const std::filesystem::path& path);

/// Finds `name` as a path, or among the shipped perception files.
[[nodiscard]] Tables find_tables(const std::string& name = "multimodal");

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
/// a large contactor on glabrous skin. One channel is flat, +12.5 dB, up to 40 Hz, and has no value above. The Pacinian
/// channel falls by 12 dB an octave to −20 dB at 250 Hz (Gescheider and Verrillo). Assumed are both levels, good to
/// ± 5 dB, and a rise by 12 dB an octave from 300 Hz to 1 kHz, which is as fast as devices modulate.
/// @param frequency_hz  from lowest_vibration_hz to highest_vibration_hz
/// @param area_factor   contact area over the large contactor's; a doubling makes the Pacinian channel 3 dB better
/// (Craig and Sherrick 1969)
/// @throws Error{bad_argument} outside of these
[[nodiscard]] double least_displacement_db(double frequency_hz, double area_factor = 1.0);

}  // namespace haptogram::perception
