// SPDX-License-Identifier: Apache-2.0
#include "pulse_check.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <utility>

namespace haptogram::sim {
namespace {

constexpr std::size_t most_messages = 8;

struct Interval {
    std::uint64_t rise;
    std::uint64_t fall;
};

/// A cycle as it was played. Silence keeps the cycle length and the prescaler of the record before it.
struct Played {
    std::uint64_t clock;               ///< in which its tick 0 begins
    std::uint64_t first;               ///< number of its tick 0, counted from the first cycle on
    std::uint32_t prescaler;           ///< clocks a tick
    std::optional<std::size_t> place;  ///< of the record in the image; empty: silence
};

/// Every tick of the span, by its number.
class Ticks {
public:
    Ticks(const Image& image, const std::vector<CycleStart>& cycles) {
        std::optional<std::size_t> present;  // the last one that was not silent
        std::uint64_t first = 0;
        for (std::size_t i = 0; i < cycles.size(); ++i) {
            const std::optional<std::size_t> place = place_of(image, cycles[i].index);
            if (place) present = place;
            const bool record = present && *present < image.records.size();
            played_.push_back({cycles[i].clock, first, record ? image.records[*present].prescaler : 1U, place});
            // Before the first record nobody knows the cycle's ticks, and no pulse needs them.
            if (i + 1 < cycles.size())
                first += record ? image.records[*present].cycle_length : cycles[i + 1].clock - cycles[i].clock;
        }
    }

    [[nodiscard]] const std::vector<Played>& cycles() const { return played_; }

    /// The clock in which a tick begins. The pins are a tick late, so a cycle's last tick lasts as long as the first
    /// one of the next cycle.
    [[nodiscard]] std::uint64_t clock_of(std::uint64_t tick) const {
        const auto after = std::ranges::upper_bound(played_, tick, {}, &Played::first);
        const Played& cycle = *std::prev(after);
        return cycle.clock + (tick - cycle.first) * cycle.prescaler;
    }

private:
    std::vector<Played> played_;
};

/// The modulation's sample in the i-th cycle.
/// @param start  number of the cycle with the first sample; negative when it was before the span
std::uint8_t sample_in(const Image& image, std::size_t i, std::optional<std::ptrdiff_t> start) {
    const std::ptrdiff_t since = start ? static_cast<std::ptrdiff_t>(i) - *start : -1;
    if (since < 0 || !image.modulation) return 255;
    const auto& [divider, samples] = *image.modulation;
    return samples[static_cast<std::size_t>(since) / divider % samples.size()];
}

/// What each channel should do over these cycles: intervals in order. Pulses that overlap or touch are merged. So are
/// those with one tick between them, of two successive cycles with different records and of any with amplitudes.
std::vector<std::vector<Interval>> expected_intervals(const Image& image, const Ticks& ticks, std::uint32_t channels,
                                                      std::optional<std::ptrdiff_t> modulation_start) {
    struct Mark {
        Interval pulse;  // in ticks
        bool fills;      // a gap of one tick before it
    };
    std::vector<std::vector<Mark>> marks(channels);
    const auto mark = [&](std::uint32_t channel, const Interval& pulse, bool fills) {
        marks[channel].push_back({pulse, fills});
    };
    std::map<std::size_t, std::vector<Emission>> emissions;  // by place
    const std::vector<Played>& cycles = ticks.cycles();
    for (std::size_t i = 0; i < cycles.size(); ++i) {
        const Played& cycle = cycles[i];
        const bool changes = i > 0 && cycles[i - 1].place != cycle.place;
        if (!cycle.place) continue;
        if (has_amplitudes(image, *cycle.place)) {
            auto found = emissions.find(*cycle.place);
            if (found == emissions.end())
                found = emissions.emplace(*cycle.place, emissions_of(image, *cycle.place)).first;
            const auto length = static_cast<std::uint32_t>(cycle_clocks(image, *cycle.place));
            const std::vector<EmissionWord> words =
                emission_words(image, found->second, length, sample_in(image, i, modulation_start));
            // The last quarter of the cycle before begins early pulses, if its ticks are clocks.
            const std::uint64_t quarter =
                i > 0 && cycles[i - 1].prescaler == 1 ? (cycle.first - cycles[i - 1].first) / 4 : 0;
            for (std::uint32_t channel = 0; channel < channels && channel < words.size(); ++channel) {
                const EmissionWord& word = words[channel];
                if (word.width == 0) continue;
                if (!word.early) {
                    mark(channel, {cycle.first + word.rise, cycle.first + word.rise + word.width}, true);
                    continue;
                }
                const std::uint64_t ahead = length - word.rise;
                mark(channel, {cycle.first - (ahead <= quarter ? ahead : 0), cycle.first + word.fall}, true);
            }
            continue;
        }
        const Record& record = image.records[*cycle.place];
        for (std::uint32_t channel = 0; channel < channels && channel < record.timings.size(); ++channel) {
            if (!record.fires(channel)) continue;
            const std::uint64_t rise = cycle.first + record.timings[channel];
            mark(channel, {rise, rise + record.pulse_length}, changes);
        }
    }
    std::vector<std::vector<Interval>> merged(channels);
    for (std::uint32_t channel = 0; channel < channels; ++channel) {
        std::vector<Interval>& all = merged[channel];
        std::ranges::stable_sort(marks[channel], {}, [](const Mark& one) { return one.pulse.rise; });
        for (const auto& [pulse, fills] : marks[channel])
            if (!all.empty() && all.back().fall + (fills ? 1 : 0) >= pulse.rise)
                all.back().fall = std::max(all.back().fall, pulse.fall);
            else
                all.push_back(pulse);
        for (Interval& pulse : all) pulse = {ticks.clock_of(pulse.rise), ticks.clock_of(pulse.fall)};
    }
    return merged;
}

}  // namespace

PulseRecorder::PulseRecorder(Board& board)
    : rise_(board.parameters().channels), rise_index_(board.parameters().channels) {
    const bool amplitudes = board.parameters().width_bits != 0;
    board.on_edge([this, amplitudes](const Edge& edge) {
        const std::uint64_t rise = rise_[edge.channel];
        if (edge.rises) {
            rise_[edge.channel] = edge.clock;
            rise_index_[edge.channel] = edge.index;
            return;
        }
        std::uint16_t index = rise_index_[edge.channel];
        if (amplitudes && !cycles_.empty())
            index = record_of_pulse(rise, edge.clock, index, cycles_.back().clock, cycles_.back().index);
        pulses_.push_back({rise, edge.clock, edge.channel, index});
    });
    board.on_cycle_start([this](const CycleStart& start) { cycles_.push_back(start); });
}

std::vector<Pulse> PulseRecorder::take() {
    if (cycles_.size() > 1) cycles_.erase(cycles_.begin(), cycles_.end() - 1);  // a pulse looks at the last one
    return std::exchange(pulses_, {});
}

std::vector<Dwell> PulseRecorder::dwells() const {
    std::vector<Dwell> result;
    for (std::size_t i = 0; i + 1 < cycles_.size(); ++i) {
        if (!result.empty() && result.back().index == cycles_[i].index) {
            result.back().end = cycles_[i + 1].clock;
            ++result.back().cycles;
        } else {
            result.push_back({cycles_[i].index, cycles_[i].clock, cycles_[i + 1].clock, 1});
        }
    }
    return result;
}

PulseReport check_pulses(const Image& image, const std::vector<CycleStart>& cycles, const std::vector<Pulse>& pulses,
                         std::uint64_t begin, std::uint64_t end, std::uint32_t channels,
                         std::optional<std::uint64_t> modulation_start) {
    std::vector<CycleStart> within;
    for (const CycleStart& cycle : cycles)
        if (cycle.clock >= begin && cycle.clock < end) within.push_back(cycle);
    const Ticks ticks(image, within);
    std::optional<std::ptrdiff_t> start;
    if (modulation_start)
        start = std::ranges::lower_bound(cycles, *modulation_start, {}, &CycleStart::clock) -
                std::ranges::lower_bound(cycles, begin, {}, &CycleStart::clock);
    std::vector<std::vector<Interval>> wanted = expected_intervals(image, ticks, channels, start);
    std::vector<std::vector<Interval>> measured(channels);
    for (const Pulse& pulse : pulses)
        if (pulse.rise >= begin && pulse.rise < end) measured[pulse.channel].push_back({pulse.rise, pulse.fall});

    PulseReport report;
    const auto complain = [&](std::uint32_t channel, const char* what, const Interval& interval) {
        ++report.violations;
        if (report.first.size() < most_messages)
            report.first.push_back(
                fmt::format("channel {}: {} pulse from clock {} to {}", channel, what, interval.rise, interval.fall));
    };
    for (std::uint32_t channel = 0; channel < channels; ++channel) {
        // A pulse that is still high at the end has no measured fall yet.
        std::vector<Interval>& expected = wanted[channel];
        std::erase_if(expected, [&](const Interval& i) { return i.fall >= end; });
        auto& seen = measured[channel];
        std::erase_if(seen, [&](const Interval& i) { return i.fall >= end; });
        std::size_t e = 0;
        std::size_t m = 0;
        while (e < expected.size() || m < seen.size()) {
            const bool both = e < expected.size() && m < seen.size();
            if (both && expected[e].rise == seen[m].rise && expected[e].fall == seen[m].fall) {
                ++report.checked;
                ++e, ++m;
            } else if (m == seen.size() || (both && expected[e].rise <= seen[m].rise)) {
                complain(channel, "missing", expected[e++]);
            } else {
                complain(channel, "unexpected", seen[m++]);
            }
        }
    }
    return report;
}

}  // namespace haptogram::sim
