// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/clock_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"

namespace haptogram::link {
namespace {

/// No question and its answer are shorter than this by any clock of a host, so no sample counts for ever.
constexpr double least_width_s = 1e-7;

double width_s(const ClockSample& sample) { return std::max(sample.answered_s - sample.asked_s, least_width_s); }
double middle_s(const ClockSample& sample) { return sample.asked_s + (sample.answered_s - sample.asked_s) / 2; }

void require_good(std::span<const ClockSample> samples) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (!(samples[i].answered_s >= samples[i].asked_s))
            throw Error(ErrorCode::bad_input, fmt::format("clock sample {}", i + 1),
                        "its answer is before its question; expected the host's own clock, which never goes back");
        if (i > 0 && samples[i].asked_s >= samples[i - 1].answered_s && samples[i].clock < samples[i - 1].clock)
            throw Error(ErrorCode::bad_input, fmt::format("clock sample {}", i + 1),
                        "the board's clock goes back: it was switched off meanwhile; begin anew");
    }
}

}  // namespace

ClockFit fit_clocks(std::span<const ClockSample> samples) {
    require_good(samples);
    double weights = 0, clock = 0, host_s = 0;
    const std::uint64_t first = samples.empty() ? 0 : samples.front().clock;
    const double first_s = samples.empty() ? 0 : middle_s(samples.front());
    const auto clocks = [first](const ClockSample& sample) {
        return static_cast<double>(static_cast<std::int64_t>(sample.clock - first));
    };
    const auto weight = [](const ClockSample& sample) { return 1 / (width_s(sample) * width_s(sample)); };
    for (const ClockSample& sample : samples) {
        weights += weight(sample);
        clock += weight(sample) * clocks(sample);
        host_s += weight(sample) * (middle_s(sample) - first_s);
    }
    clock /= weights;
    host_s /= weights;
    double squares = 0, products = 0;
    for (const ClockSample& sample : samples) {
        const double away = clocks(sample) - clock;
        squares += weight(sample) * away * away;
        products += weight(sample) * away * (middle_s(sample) - first_s - host_s);
    }
    if (!(squares > 0))
        throw Error(ErrorCode::bad_input, "clock samples",
                    fmt::format("{} of them with no two different clocks, expected at least two", samples.size()));
    ClockFit fit;
    const double whole = std::floor(clock);
    fit.s_per_clock = products / squares;
    fit.origin = first + static_cast<std::uint64_t>(static_cast<std::int64_t>(whole));
    fit.origin_s = first_s + host_s - fit.s_per_clock * (clock - whole);
    double residues = 0, halves = 0;
    for (const ClockSample& sample : samples) {
        const double residue = middle_s(sample) - fit.host_s(sample.clock);
        residues += weight(sample) * residue * residue;
        halves += weight(sample) * width_s(sample) / 2;
    }
    fit.spread_s = std::sqrt(residues / weights);
    fit.error_s = halves / weights;
    return fit;
}

}  // namespace haptogram::link
