// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>

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

}  // namespace haptogram::perception
