// SPDX-License-Identifier: Apache-2.0
// What the pins must do when records are played whose words are made anew in each carrier period: the host's model of
// the arithmetic (format/emission.hpp) gives each measured cycle its pulses, and what was measured is compared with
// them, to the clock.
#pragma once
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/format/emission.hpp"
#include "haptogram/format/pulses.hpp"

namespace haptogram::test {

/// What an index plays: one emission a channel, in a cycle of so many clocks. Of a raw record the phases are ticks of a
/// clock.
struct Played {
    std::vector<Emission> emissions;
    std::uint32_t cycle = 1250;
    bool raw = false;
    std::uint32_t raw_ticks = 0;
};
using Book = std::map<std::uint16_t, Played>;

/// A carrier cycle at the pins.
struct MeasuredCycle {
    std::uint64_t clock;
    std::uint16_t index;
};

/// The settings of one measured cycle that no record says.
struct Setting {
    std::uint8_t modulation = 255;
    SlewLimit slew{};
    bool new_target = false;
};

struct Comparison {
    std::size_t pulses = 0;  ///< expected in the span
    std::size_t wrong = 0;   ///< channels that differ
    std::size_t bent = 0;    ///< cycles in which the slew limiter kept a channel from its target
    std::string first;       ///< difference, in words
};

/// The words of the header and of the channels of a record of amplitudes.
/// @param words  {amplitude, phase}, one a channel
inline std::vector<std::uint16_t> amplitude_record(std::uint32_t cycle, const std::vector<std::uint16_t>& words) {
    std::vector<std::uint16_t> record = {static_cast<std::uint16_t>(cycle), static_cast<std::uint16_t>(cycle >> 16), 1,
                                         1 << 8};
    record.insert(record.end(), words.begin(), words.end());
    return record;
}

inline Played played(std::uint32_t cycle, const std::vector<std::uint16_t>& words) {
    Played result{{}, cycle};
    for (const std::uint16_t word : words)
        result.emissions.push_back(
            {static_cast<std::uint16_t>((word >> 8) * 257), static_cast<std::uint16_t>(word << 8)});
    return result;
}

/// Compares the pulses of the measured cycles `begin` + 3 to `end` with what the book says. Before `begin` all channels
/// were silent, or the first three cycles make that forgotten.
/// @param setting  of each cycle, by its number
/// @param model    where the channels are before `begin`; afterwards, where they are at the end
inline Comparison compare_periods(const std::vector<MeasuredCycle>& cycles, const std::vector<Pulse>& pulses,
                                  const Book& book, std::size_t begin, std::size_t end,
                                  const std::function<Setting(std::size_t)>& setting, EmissionModel& model) {
    using Span = std::pair<std::uint64_t, std::uint64_t>;
    REQUIRE(end < cycles.size());
    REQUIRE(begin + 4 < end);
    const std::size_t channels = model.places().size();
    Comparison result;
    std::vector<std::vector<Span>> high(channels);
    std::vector<Emission> still(channels);  // silence after a record of amplitudes keeps its phases
    bool amplitudes = false;
    for (std::size_t i = begin; i < end; ++i) {
        const std::uint64_t clock = cycles[i].clock;
        if (cycles[i].index != 0) {
            const Played& one = book.at(cycles[i].index);
            REQUIRE(cycles[i + 1].clock - clock == one.cycle);
            amplitudes = !one.raw;
            for (std::size_t k = 0; one.raw && k < channels; ++k)
                if (one.emissions[k].phase < one.cycle && one.raw_ticks > 0)
                    high[k].emplace_back(clock + one.emissions[k].phase,
                                         clock + one.emissions[k].phase + one.raw_ticks);
            still = one.emissions;
        } else {
            for (Emission& e : still) e.amplitude = 0;
        }
        if (!amplitudes) continue;
        const Setting s = setting(i);
        EmissionPeriod period;
        period.cycle_ticks = static_cast<std::uint32_t>(cycles[i + 1].clock - clock);
        period.modulation = s.modulation;
        period.new_target = s.new_target;
        period.slew = s.slew;
        const std::vector<EmissionWord> words = model.period(still, period);
        bool bent = false;
        for (std::size_t k = 0; k < channels; ++k) {
            bent = bent || words[k].bent;
            if (words[k].width == 0) continue;
            // One that is early begins in the cycle before, in whose last quarter its word is there.
            const std::uint64_t ahead = words[k].early ? period.cycle_ticks - words[k].rise : 0;
            const bool whole = i > 0 && ahead <= (clock - cycles[i - 1].clock) / 4;
            const std::uint64_t rise = !words[k].early ? clock + words[k].rise : whole ? clock - ahead : clock;
            high[k].emplace_back(rise, words[k].early ? clock + words[k].fall : rise + words[k].width);
        }
        result.bent += bent;
    }
    const std::uint64_t from = cycles[begin + 3].clock, to = cycles[end - 1].clock;
    const auto within = [&](const Span& one) { return one.first >= from && one.second < to; };
    std::vector<std::vector<Span>> measured(channels);
    for (const Pulse& p : pulses)
        if (within({p.rise, p.fall})) measured[p.channel].emplace_back(p.rise, p.fall);
    for (std::size_t k = 0; k < channels; ++k) {
        std::sort(high[k].begin(), high[k].end());
        std::vector<Span> expected;
        for (const auto& [rise, fall] : high[k]) {
            if (!expected.empty() && rise <= expected.back().second + 1)  // a gap of one tick is filled
                expected.back().second = std::max(expected.back().second, fall);
            else
                expected.emplace_back(rise, fall);
        }
        std::erase_if(expected, [&](const Span& one) { return !within(one); });
        result.pulses += expected.size();
        if (expected == measured[k]) continue;
        ++result.wrong;
        if (!result.first.empty()) continue;
        std::size_t i = 0;
        while (i < expected.size() && i < measured[k].size() && expected[i] == measured[k][i]) ++i;
        const auto text = [i](const std::vector<Span>& list) {
            return i < list.size() ? std::to_string(list[i].first) + "…" + std::to_string(list[i].second) : "none";
        };
        result.first = "channel " + std::to_string(k) + ": expected " + text(expected) + ", found " +
                       text(measured[k]) + "; compared from clock " + std::to_string(from);
    }
    return result;
}

}  // namespace haptogram::test
