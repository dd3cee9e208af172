// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/inspect.hpp"

#include <algorithm>

#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

void take(TimingRange& range, std::uint32_t start, std::uint32_t ticks) {
    if (range.firing++ == 0) range = {start, start, 1, ticks, ticks};
    range.lowest = std::min(range.lowest, start);
    range.highest = std::max(range.highest, start);
    range.shortest = std::min(range.shortest, ticks);
    range.longest = std::max(range.longest, ticks);
}

TimingRange range_of(const Record& record) {
    TimingRange range;
    for (std::size_t channel = 0; channel < record.timings.size(); ++channel)
        if (record.fires(channel)) take(range, record.timings[channel], record.pulse_length);
    return range;
}

TimingRange range_of(const Image& image, std::size_t place) {
    if (!has_amplitudes(image, place)) return range_of(image.records[place]);
    TimingRange range;
    try {
        const auto cycle = static_cast<std::uint32_t>(cycle_clocks(image, place));
        for (const EmissionWord& word : emission_words(image, emissions_of(image, place), cycle))
            if (word.width > 0) take(range, word.rise, word.width);
    } catch (const Error&) {
        return {};  // a cycle that has no such pulses, or garbled foci, which problems() names
    }
    return range;
}

}  // namespace

Inspection inspect(std::string_view hex, const std::string& where) {
    Inspection found;
    found.image = from_intel_hex(hex, where);
    for (std::size_t place = 0; place < found.image.record_count(); ++place)
        found.ranges.push_back(range_of(found.image, place));
    found.problems = problems(found.image);
    return found;
}

}  // namespace haptogram
