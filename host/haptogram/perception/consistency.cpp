// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/consistency.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::perception {
namespace {

/// The whole numbers n for which n·scale/count would be printed as `value`: from … to; empty when from > to.
struct Counts {
    long long from, to;
};
Counts counts_of(double value, int decimals, int count, double scale) {
    if (count < 1) throw bad_argument("count", fmt::format("at least one person is needed, found {}", count));
    if (!std::isfinite(value)) throw bad_argument("value", "a printed value must be a number");
    const double half = 0.5 * std::pow(10.0, -decimals) * (1.0 + 1e-9);
    return {std::llround(std::ceil((value - half) * count / scale - 1e-9)),
            std::llround(std::floor((value + half) * count / scale + 1e-9))};
}

boost::math::fisher_f distribution(double numerator_df, double denominator_df) {
    if (!(numerator_df > 0.0 && denominator_df > 0.0))
        throw bad_argument("degrees_of_freedom",
                           fmt::format("must be positive, found {:g} and {:g}", numerator_df, denominator_df));
    return {numerator_df, denominator_df};
}

}  // namespace

double p_of_f(double f, double numerator_df, double denominator_df) {
    const auto dist = distribution(numerator_df, denominator_df);
    if (!(f >= 0.0 && std::isfinite(f))) throw bad_argument("f", fmt::format("F is not negative, found {:g}", f));
    return boost::math::cdf(boost::math::complement(dist, f));
}

double f_of_p(double p, double numerator_df, double denominator_df) {
    const auto dist = distribution(numerator_df, denominator_df);
    if (!(p > 0.0 && p <= 1.0)) throw bad_argument("p", fmt::format("a p-value is above 0 and up to 1, found {:g}", p));
    return boost::math::quantile(boost::math::complement(dist, p));
}

bool mean_of_integers(double mean, int decimals, int count) {
    const Counts counts = counts_of(mean, decimals, count, 1.0);
    return counts.from <= counts.to;
}

bool percentages_of(std::span<const double> percentages, int decimals, int count) {
    long long least = 0, most = 0;
    for (const double percentage : percentages) {
        const Counts counts = counts_of(percentage, decimals, count, 100.0);
        if (counts.from > counts.to) return false;
        least += counts.from;
        most += counts.to;
    }
    return least <= count && count <= most;
}

int fewest_people(std::span<const double> percentages, int decimals, int most) {
    for (int count = 1; count <= most; ++count)
        if (percentages_of(percentages, decimals, count)) return count;
    throw bad_input("percentages", fmt::format("no number of people up to {} gives them", most));
}

}  // namespace haptogram::perception
