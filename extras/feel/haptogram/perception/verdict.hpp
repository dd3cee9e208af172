// SPDX-License-Identifier: Apache-2.0
// Whether something is felt: one rule, for whoever asks.
#pragma once
#include <limits>
#include <optional>
#include <span>
#include <string>

#include "haptogram/perception/felt.hpp"
#include "haptogram/verbs/level.hpp"

namespace haptogram::perception {

enum class Answer { felt, perhaps, not_felt };
/// "felt", "perhaps" or "not felt".
[[nodiscard]] const char* words_of(Answer answer);

/// How far a vibration is over what an average palm or finger just feels, and how far it may be, in decibels of force.
struct Verdict {
    double over_db = -std::numeric_limits<double>::infinity();  ///< expected
    double least_db = -std::numeric_limits<double>::infinity(), most_db = -std::numeric_limits<double>::infinity();
    /// Felt when even the least is over the threshold, not felt when even the most is below it.
    [[nodiscard]] Answer answer() const {
        return least_db > 0.0 ? Answer::felt : most_db < 0.0 ? Answer::not_felt : Answer::perhaps;
    }
};

/// A focus that goes round and round is felt at these rates, as *Takahashi et al. 2020* (10 to 200 Hz) and *Morisaki et
/// al. 2022* (from 5 Hz) found.
inline constexpr double slowest_round_hz = 5.0, fastest_round_hz = 200.0;

/// What is not known of a vibration's level and of its threshold:
///
/// - the array's level, as it says
/// - half of the thresholds' interval in the tables (Multimodal, Table III)
/// - 5 dB where the course of displacement thresholds carries the tables on
/// - more, for a bare hand: the tables begin with one that holds 1 N. From 3 to 1 N the threshold falls by 1.5 dB, and
///   as much again is allowed for
/// - more, for a focus that comes round `rounds_hz` times a second: it is felt stronger than one that rests under a
///   modulation of the same largest force (Takahashi et al. 2020), so it may be felt as that one would be
///
/// The first three are independent, and their squares are summed.
/// @param largest_n  the largest force at the place, N
/// @throws Error{bad_argument} naming "grip"
[[nodiscard]] Verdict verdict_of(const Felt& felt, const ExpectedLevel& level, const Tables& tables, Region region,
                                 double grip_n, double largest_n, std::optional<double> rounds_hz);

/// What the places of one image come to: felt when all are, not felt when none is even perhaps.
[[nodiscard]] Answer answer_of(std::span<const Verdict> places);
/// The same as a sentence that begins with the answer and a colon, with the decibels expected and their span.
[[nodiscard]] std::string sentence_of(std::span<const Verdict> places);

}  // namespace haptogram::perception
