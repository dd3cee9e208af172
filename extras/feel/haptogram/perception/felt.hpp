// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/perception/spectrum.hpp"
#include "haptogram/perception/tables.hpp"
#include "haptogram/perception/threshold.hpp"

namespace haptogram::perception {

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
/// that mean (perception/waveform.hpp), and is what skin feels. Beyond the tables' frequencies the threshold follows
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

/// What a place feels, by the strongest line of its force over the threshold.
struct Felt {
    std::vector<FeltLine> lines;  ///< from 10 Hz to 1 kHz, the strongest over its threshold first; at most `most_lines`
    std::optional<double> magnitude;  ///< perceived (Multimodal eq. 10), of the strongest line within the tables
    std::string no_magnitude;         ///< why there is none
};

/// @param spectrum  of the force, N
/// @throws Error{bad_argument} naming "grip"
[[nodiscard]] Felt felt_of(std::span<const Line> spectrum, const Tables& tables, Region region, double grip_n,
                           std::size_t most_lines = 6);

}  // namespace haptogram::perception
