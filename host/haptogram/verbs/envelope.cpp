// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/envelope.hpp"

#include <algorithm>
#include <map>

#include "haptogram/acoustics/propagation.hpp"

namespace haptogram {

Envelope envelope_of(std::span<const Pulse> pulses, double clock_hz, std::uint64_t cycle_clocks, bool silent_before) {
    std::map<std::uint32_t, std::vector<std::uint64_t>> rises;
    for (const Pulse& pulse : pulses) rises[pulse.channel].push_back(pulse.rise);
    const auto most = std::max_element(rises.begin(), rises.end(),
                                       [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    Envelope envelope;
    if (most == rises.end()) return envelope;
    const std::vector<std::uint64_t>& times = most->second;
    std::vector<std::uint64_t> begins;
    for (std::size_t i = silent_before ? 1 : 0; i < times.size(); ++i)
        if (i == 0 || 2 * (times[i] - times[i - 1]) > 3 * cycle_clocks) begins.push_back(times[i]);
    envelope.bursts = begins.size();
    if (begins.size() >= 2)
        envelope.frequency_hz =
            static_cast<double>(begins.size() - 1) * clock_hz / static_cast<double>(begins.back() - begins.front());
    return envelope;
}

double share_of_full_drive(const Array& array, std::span<const std::complex<double>> drives, Vec3 focus) {
    return std::abs(pressure(array, drives, focus)) / std::abs(pressure(array, ideal_drives(array, focus), focus));
}

}  // namespace haptogram
