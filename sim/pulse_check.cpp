// SPDX-License-Identifier: Apache-2.0
#include "pulse_check.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <map>

namespace haptogram::sim {
namespace {

constexpr std::size_t most_messages = 8;

struct Interval {
    std::uint64_t rise;
    std::uint64_t fall;
};

/// A cycle as it was played. Silence keeps the cycle length and the prescaler of the record before it.
struct Played {
    std::uint64_t clock;      ///< in which its tick 0 begins
    std::uint64_t first;      ///< number of its tick 0, counted from the first cycle on
    std::uint32_t prescaler;  ///< clocks a tick
    const Record* record;     ///< nullptr: silence
};

/// Every tick of the span, by its number.
class Ticks {
public:
    Ticks(const Image& image, const std::vector<CycleStart>& cycles) {
        const Record* present = nullptr;  // the last one that was not silent
        std::uint64_t first = 0;
        for (std::size_t i = 0; i < cycles.size(); ++i) {
            const std::uint16_t index = cycles[i].index;
            const bool silent = index == 0 || index > image.records.size();
            if (!silent) present = &image.records[index - 1U];
            played_.push_back(
                {cycles[i].clock, first, present != nullptr ? present->prescaler : 1U, silent ? nullptr : present});
            // Before the first record nobody knows the cycle's ticks, and no pulse needs them.
            if (i + 1 < cycles.size())
                first += present != nullptr ? present->cycle_length : cycles[i + 1].clock - cycles[i].clock;
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

/// What one channel should do over these cycles: intervals in order. Pulses that overlap or touch are merged. So are
/// those of two successive cycles with different records and one tick between them.
std::vector<Interval> expected_intervals(const Ticks& ticks, std::uint32_t channel) {
    std::vector<Interval> marked;  // in ticks
    const Played* before = nullptr;
    for (const Played& cycle : ticks.cycles()) {
        const bool changes = before != nullptr && before->record != cycle.record;
        before = &cycle;
        if (cycle.record == nullptr) continue;
        const Record& record = *cycle.record;
        const std::uint32_t timing =
            channel < record.timings.size() ? record.timings[channel] : interface::silent_timing;
        if (timing >= record.cycle_length || timing == interface::silent_timing || record.pulse_length == 0) continue;
        const Interval pulse{cycle.first + timing, cycle.first + timing + record.pulse_length};
        if (!marked.empty() && marked.back().fall + (changes ? 1 : 0) >= pulse.rise)
            marked.back().fall = std::max(marked.back().fall, pulse.fall);
        else
            marked.push_back(pulse);
    }
    for (Interval& pulse : marked) pulse = {ticks.clock_of(pulse.rise), ticks.clock_of(pulse.fall)};
    return marked;
}

}  // namespace

PulseRecorder::PulseRecorder(Board& board)
    : rise_(board.parameters().channels), rise_index_(board.parameters().channels) {
    board.on_edge([this](const Edge& edge) {
        if (edge.rises) {
            rise_[edge.channel] = edge.clock;
            rise_index_[edge.channel] = edge.index;
        } else {
            pulses_.push_back({rise_[edge.channel], edge.clock, edge.channel, rise_index_[edge.channel]});
        }
    });
    board.on_cycle_start([this](const CycleStart& start) { cycles_.push_back(start); });
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
                         std::uint64_t begin, std::uint64_t end, std::uint32_t channels) {
    std::vector<CycleStart> within;
    for (const CycleStart& cycle : cycles)
        if (cycle.clock >= begin && cycle.clock < end) within.push_back(cycle);
    const Ticks ticks(image, within);
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
        std::vector<Interval> expected = expected_intervals(ticks, channel);
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
