// SPDX-License-Identifier: Apache-2.0
#include "haptogram/perception/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptogram::perception {
namespace {

constexpr double displacement_known_to_db = 5.0;
constexpr double modulated_at_hz = 200.0;  ///< where a palm feels the least

double decibels(double ratio) { return 20.0 * std::log10(ratio); }

/// How much less than the first row's threshold a bare hand's may be: as much as the first is below the second.
double bare_hand_db(const Tables& tables, Region region, double grip_n) {
    const ThresholdRow &first = tables.thresholds.at(0), &second = tables.thresholds.at(1);
    if (grip_n > first.grip_n) return 0.0;
    const auto centre = [region](const ThresholdRow& row) {
        return (region == Region::palm ? row.palm : row.finger).centre_gf();
    };
    return decibels(centre(second) / centre(first));
}

}  // namespace

const char* words_of(Answer answer) {
    switch (answer) {
        case Answer::felt: return "felt";
        case Answer::perhaps: return "perhaps";
        case Answer::not_felt: return "not felt";
    }
    return "not felt";
}

Verdict verdict_of(const Felt& felt, const ExpectedLevel& level, const Tables& tables, Region region, double grip_n,
                   double largest_n, std::optional<double> rounds_hz) {
    Verdict verdict;
    if (felt.lines.empty()) return verdict;
    const Interval interval = threshold_interval(tables, region, grip_n);
    const double half_db = decibels(interval.high_gf / interval.low_gf) / 2.0;
    const double curve_db = felt.lines.front().basis == Basis::tables ? 0.0 : displacement_known_to_db;
    const double bare_db = bare_hand_db(tables, region, grip_n);
    verdict.over_db = felt.over_db;
    verdict.least_db = felt.over_db - std::hypot(level.less_db, half_db, curve_db);
    verdict.most_db = felt.over_db + std::hypot(level.more_db, half_db, curve_db) + bare_db;
    if (rounds_hz && *rounds_hz >= slowest_round_hz && *rounds_hz <= fastest_round_hz) {
        // The part at its frequency of a square wave from nothing to the largest force.
        const double resting_n = 2.0 / std::numbers::pi * largest_n;
        const double resting_db =
            decibels(resting_n / least_vibration(tables, region, modulated_at_hz, grip_n).force_n);
        verdict.most_db = std::max(verdict.most_db, resting_db + std::hypot(level.more_db, half_db) + bare_db);
    }
    return verdict;
}

Answer answer_of(std::span<const Verdict> places) {
    const auto is = [](Answer answer) { return [answer](const Verdict& place) { return place.answer() == answer; }; };
    if (std::ranges::all_of(places, is(Answer::not_felt))) return Answer::not_felt;
    return std::ranges::all_of(places, is(Answer::felt)) ? Answer::felt : Answer::perhaps;
}

std::string sentence_of(std::span<const Verdict> places) {
    const auto how_many = [&](Answer answer) {
        return std::ranges::count_if(places, [answer](const Verdict& place) { return place.answer() == answer; });
    };
    const auto by_db = [](const Verdict& a, const Verdict& b) { return a.over_db < b.over_db; };
    if (places.empty()) return "not felt: nothing plays";
    const Verdict least = *std::ranges::min_element(places, by_db), most = *std::ranges::max_element(places, by_db);
    if (!std::isfinite(most.over_db)) return "not felt: nothing alternates between 10 Hz and 1 kHz";
    const std::string strength =
        places.size() == 1 || !std::isfinite(least.over_db)
            ? fmt::format("{:+.1f} dB over the least felt, {:+.1f} to {:+.1f} with what is not known", most.over_db,
                          most.least_db, most.most_db)
            : fmt::format(
                  "{:+.1f} to {:+.1f} dB over the least felt; the strongest {:+.1f} to {:+.1f} "
                  "with what is not known",
                  least.over_db, most.over_db, most.least_db, most.most_db);
    const auto total = static_cast<std::ptrdiff_t>(places.size());
    const std::ptrdiff_t felt = how_many(Answer::felt), perhaps = how_many(Answer::perhaps);
    if (felt == total) return fmt::format("felt: clear everywhere, {}", strength);
    if (felt + perhaps == 0) return fmt::format("not felt: {}", strength);
    return fmt::format("perhaps: felt at {}, perhaps at {}, not at {} of {} places, {}", felt, perhaps,
                       total - felt - perhaps, total, strength);
}

}  // namespace haptogram::perception
