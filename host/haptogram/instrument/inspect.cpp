// SPDX-License-Identifier: Apache-2.0
#include "haptogram/instrument/inspect.hpp"

#include <algorithm>

namespace haptogram {
namespace {

TimingRange range_of(const Record& record) {
    TimingRange range{interface::silent_timing, 0, 0};
    for (std::size_t channel = 0; channel < record.timings.size(); ++channel) {
        if (!record.fires(channel)) continue;
        range.lowest = std::min<std::uint32_t>(range.lowest, record.timings[channel]);
        range.highest = std::max<std::uint32_t>(range.highest, record.timings[channel]);
        ++range.firing;
    }
    return range.firing == 0 ? TimingRange{} : range;
}

}  // namespace

Inspection inspect(std::string_view hex, const std::string& where) {
    Inspection found;
    found.image = from_intel_hex(hex, where);
    for (const Record& record : found.image.records) found.ranges.push_back(range_of(record));
    found.problems = problems(found.image);
    return found;
}

}  // namespace haptogram
