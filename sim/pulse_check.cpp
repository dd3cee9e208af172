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

/// What one channel should do over these cycles: intervals in order, overlapping or touching ones merged. A pulse is
/// counted in ticks, so one that reaches into a record with another prescaler is stretched or shrunk from there.
std::vector<Interval> expected_intervals(const Image& image, const std::vector<CycleStart>& cycles,
                                         std::uint32_t channel) {
    std::vector<Interval> result;
    std::uint64_t prescaler = 1;
    for (const CycleStart& cycle : cycles) {
        if (cycle.index == 0 || cycle.index > image.records.size()) continue;  // silence keeps the present tick
        const Record& record = image.records[cycle.index - 1U];
        if (record.prescaler != prescaler && !result.empty() && result.back().fall > cycle.clock) {
            const std::uint64_t ticks_left = (result.back().fall - cycle.clock) / prescaler;
            result.back().fall = cycle.clock + ticks_left * record.prescaler;
        }
        prescaler = record.prescaler;
        const std::uint32_t timing =
            channel < record.timings.size() ? record.timings[channel] : interface::silent_timing;
        if (timing >= record.cycle_length || timing == interface::silent_timing || record.pulse_length == 0) continue;
        const Interval pulse{cycle.clock + timing * prescaler,
                             cycle.clock + (timing + record.pulse_length) * prescaler};
        if (!result.empty() && result.back().fall >= pulse.rise)
            result.back().fall = std::max(result.back().fall, pulse.fall);
        else
            result.push_back(pulse);
    }
    return result;
}

}  // namespace

PulseRecorder::PulseRecorder(SimulatedBoard& board)
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
        std::vector<Interval> expected = expected_intervals(image, within, channel);
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
