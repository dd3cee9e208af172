// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/perception/tables.hpp"

namespace haptogram::perception {

// How much two stimuli must differ to be told apart. The numbers are other people's, of other skin and other devices,
// so they are ranges.

/// How many steps of strength lie between the least that is felt and a vibration that is `over_db` above it: at least
/// and at most, by steps of 2.98 and 1.65 dB (Israr et al. 2006: sines of 2 to 300 Hz at the index finger's pad, 20 and
/// 35 dB above the least felt). 0 below the least.
[[nodiscard]] std::array<unsigned, 2> strength_steps(double over_db);

/// The next higher frequency that is told from `hz`: at least and at most, by Weber fractions of 0.13 and 0.38 (the
/// same work). Nothing outside of its 2 to 300 Hz.
[[nodiscard]] std::optional<std::array<double, 2>> next_frequency_hz(double hz);

/// Two foci that sound at the same time, nearer to each other than this, were taken for one by more than 95 % (Howard
/// et al. 2022: amplitude modulation, on the palm).
inline constexpr double fused_below_m = 15e-3;
/// Mean error of a hand that points at where it feels a focus (Wilson et al. 2014).
inline constexpr double place_error_m = 8.5e-3;

/// A sinusoidal part of a signal that repeats.
struct Line {
    double hz = 0.0;
    double amplitude = 0.0;  ///< peak value, in the signal's unit
};

/// The lines of a signal that repeats, from 0 Hz, its mean, up to half the sampling rate: those of the discrete Fourier
/// transform, rate/n apart for n samples. A line is A·cos(2πft + φ).
/// @param rate_hz  of the samples
[[nodiscard]] std::vector<Line> lines_of(std::span<const double> samples, double rate_hz);

/// The A-weighting of IEC 61672-1, as a factor on an amplitude: 1 at 1 kHz.
[[nodiscard]] double a_weighting(double hz);

/// What a threshold of a vibration rests on.
enum class Basis {
    tables,        ///< measured there, within the tables' frequencies
    displacement,  ///< carried on beyond them by the course of the displacement thresholds, from 10 Hz to 1 kHz
    none,          ///< nothing is known here
};
[[nodiscard]] const char* name_of(Basis basis);

/// The least vibrating force that is felt, as the peak value of a sine, N.
///
/// The tables give the mean output of a square wave of 50 % duty. Its part at the frequency of modulation is 4/π of
/// that mean (perception/magnitude.hpp), and is what skin feels. Beyond the tables' frequencies the threshold follows
/// least_displacement_db(), fixed to the tables at their end. That takes the skin for equally soft at both frequencies,
/// which is a choice of ours: such a threshold is an estimate.
struct LeastForce {
    double force_n = 0.0;
    Basis basis = Basis::none;
};
/// @throws Error{bad_argument} naming "grip" as threshold_interval() does
[[nodiscard]] LeastForce least_vibration(const Tables& tables, Region region, double hz, double grip_n);

/// A line of a force's spectrum beside what is felt there.
struct FeltLine {
    double hz = 0.0;
    double force_n = 0.0;  ///< peak value
    double least_n = 0.0;  ///< the least that is felt, peak value
    double over_db = 0.0;  ///< 20·lg(force/least): it is expected to be felt above 0
    Basis basis = Basis::none;
};

/// From here on vibrations are felt by one channel, the Pacinian one, which sums their power over time and frequency.
inline constexpr double pacinian_from_hz = 40.0;

/// What a place feels.
struct Felt {
    std::vector<FeltLine> lines;  ///< from 10 Hz to 1 kHz, the strongest over its threshold first; at most `most_lines`
    /// All lines together over what is just felt: the root of the sum of (force/least)² from `pacinian_from_hz` on
    /// (Gescheider et al. 1994: sines and bands of noise are detected by their power), or the strongest line below,
    /// where nothing is summed (Gescheider 1976). −∞ without lines.
    double over_db = -std::numeric_limits<double>::infinity();
    std::optional<double> magnitude;  ///< perceived (Multimodal eq. 10), of the strongest line within the tables
    std::string no_magnitude;         ///< why there is none
};

/// @param spectrum  of the force, N
/// @throws Error{bad_argument} naming "grip"
[[nodiscard]] Felt felt_of(std::span<const Line> spectrum, const Tables& tables, Region region, double grip_n,
                           std::size_t most_lines = 6);

}  // namespace haptogram::perception
