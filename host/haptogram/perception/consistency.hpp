// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>

namespace haptogram::perception {

/// Whether printed statistics can be true.

/// The p-value that belongs to an F statistic: the part of the F distribution above it.
/// @throws Error{bad_argument} for F < 0 or degrees of freedom that are not positive
[[nodiscard]] double p_of_f(double f, double numerator_df, double denominator_df);

/// The F statistic that belongs to a p-value: the inverse of p_of_f().
[[nodiscard]] double f_of_p(double p, double numerator_df, double denominator_df);

/// Whether a mean that was printed with `decimals` digits can be that of `count` whole numbers (the GRIM test). A value
/// that lies half way between two may have been rounded either way.
[[nodiscard]] bool mean_of_integers(double mean, int decimals, int count);

/// Whether percentages that were printed with `decimals` digits can be those of `count` people, each counted once.
[[nodiscard]] bool percentages_of(std::span<const double> percentages, int decimals, int count);

/// The fewest people that could have given such percentages. @throws Error{bad_input} when none up to `most` could
[[nodiscard]] int fewest_people(std::span<const double> percentages, int decimals, int most = 100000);

}  // namespace haptogram::perception
