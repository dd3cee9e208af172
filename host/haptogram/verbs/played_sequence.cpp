// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/played_sequence.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/measure.hpp"

namespace haptogram {
namespace {

constexpr std::uint64_t most_periods = 10'000'000;  ///< some minutes

/// A pulse within a carrier period: channel, and clocks of its edges from the period's beginning.
using Edges = std::vector<std::tuple<std::uint32_t, std::int64_t, std::int64_t>>;

std::vector<std::complex<double>> drives_of(const Edges& edges, const Manifest& manifest) {
    std::vector<std::complex<double>> drives(manifest.array.elements.size());
    const double clock_s = 1.0 / manifest.timer.clock_hz;
    for (const auto& [channel, rise, fall] : edges) {
        const DrivePulse pulse{static_cast<double>(rise) * clock_s, static_cast<double>(fall) * clock_s};
        drives[channel] += manifest.array.transducer.source_pa_m *
                           carrier_component({&pulse, 1}, manifest.timer.carrier_hz(), manifest.timer.period_s());
    }
    return drives;
}

}  // namespace

DriveSequence sequence_of(const Bundle& bundle) {
    const Manifest& manifest = bundle.manifest;
    DriveSequence sequence;
    sequence.carrier_hz = manifest.timer.carrier_hz();
    sequence.drives.emplace_back(manifest.array.elements.size());  // silence
    const SampledModulation steady{1, {255}};
    const SampledModulation& modulation = bundle.image.modulation.value_or(steady);
    std::map<std::pair<std::size_t, std::uint8_t>, std::size_t> sets;  // of a place and a sample
    const auto set_of = [&](std::optional<std::size_t> place, std::uint8_t sample) -> std::size_t {
        if (!place) return 0;
        const auto [at, is_new] = sets.try_emplace({*place, sample}, sequence.drives.size());
        if (is_new) sequence.drives.push_back(haptogram::drives_of(manifest, bundle.image, *place, sample));
        return at->second;
    };
    std::uint64_t pass = 0;
    for (const SequenceEntry& entry : bundle.image.sequence) pass += entry.dwell;
    const std::uint64_t round = std::uint64_t{modulation.divider} * modulation.samples.size();
    const std::uint64_t end = bundle.image.modulation ? std::lcm(pass, round) : pass;
    if (end > most_periods)
        throw bad_input(bundle.name,
                        fmt::format("the sequence of {} carrier periods and the modulation of {} meet again after {} "
                                    "only, and a spectrum has at most {}; take a rate that divides the modulation's "
                                    "frequency",
                                    pass, round, end, most_periods));
    for (std::uint64_t now = 0; now < end;) {
        for (const SequenceEntry& entry : bundle.image.sequence) {
            const auto place = manifest.place_of(entry.index);
            const std::uint64_t until = now + entry.dwell;
            while (now < until) {
                const std::uint64_t sample = now / modulation.divider;
                const std::uint64_t next =
                    bundle.image.modulation ? std::min(until, (sample + 1) * modulation.divider) : until;
                sequence.steps.push_back(
                    {set_of(place, modulation.samples[sample % modulation.samples.size()]), next - now, entry.index});
                now = next;
            }
        }
    }
    return sequence;
}

DriveSequence sequence_of(const Manifest& manifest, const std::vector<Pulse>& pulses, const std::string& name) {
    if (pulses.empty()) throw bad_input(name, "no pulses in it; expected what a simulation measured");
    const std::uint64_t cycle = manifest.timer.cycle_clocks();
    std::uint64_t first = pulses.front().rise, last = 0;
    for (const Pulse& pulse : pulses) {
        if (pulse.channel >= manifest.array.elements.size())
            throw bad_input(
                name,
                fmt::format("a pulse on channel {}, but the array has {} elements; these pulses are another array's",
                            pulse.channel, manifest.array.elements.size()));
        (void)place_of(manifest, pulse, name);
        first = std::min(first, pulse.rise);
        last = std::max(last, pulse.rise);
    }
    std::vector<Edges> periods((last - first) / cycle + 1);
    std::vector<std::uint32_t> records(periods.size());
    for (const Pulse& pulse : pulses) {
        const std::uint64_t period = (pulse.rise - first) / cycle;
        const auto from = static_cast<std::int64_t>(first + period * cycle);
        periods[period].emplace_back(pulse.channel, static_cast<std::int64_t>(pulse.rise) - from,
                                     static_cast<std::int64_t>(pulse.fall) - from);
        records[period] = pulse.index;
    }
    DriveSequence sequence;
    sequence.carrier_hz = manifest.timer.carrier_hz();
    const std::size_t pass = manifest.repeat_periods();
    sequence.repeats = pass > 0 && periods.size() >= 2 * pass;
    // The last pulses may rise within a period that is not whole.
    const std::size_t begin = sequence.repeats ? pass : 0;
    const std::size_t end = sequence.repeats ? periods.size() / pass * pass : periods.size();
    std::map<Edges, std::size_t> sets;
    for (std::size_t i = begin; i < end; ++i) {
        std::sort(periods[i].begin(), periods[i].end());
        const auto [at, is_new] = sets.try_emplace(std::move(periods[i]), sequence.drives.size());
        if (is_new) sequence.drives.push_back(drives_of(at->first, manifest));
        DriveSequence::Step* const before = sequence.steps.empty() ? nullptr : &sequence.steps.back();
        if (before != nullptr && before->set == at->second && before->record == records[i])
            ++before->periods;
        else
            sequence.steps.push_back({at->second, 1, records[i]});
    }
    return sequence;
}

Path places_of(const Manifest& manifest, const DriveSequence& sequence) {
    Path path;
    for (const DriveSequence::Step& step : sequence.steps) {
        PathStep made;
        made.periods = static_cast<std::uint32_t>(step.periods);
        if (step.record > 0) made.foci = manifest.records.at(manifest.place_of(step.record).value()).foci;
        std::erase_if(made.foci, [](const Focus& focus) { return focus.amplitude == 0.0; });  // held down
        for (Focus& focus : made.foci) focus.amplitude = 1.0;
        if (!path.steps.empty() && path.steps.back().foci == made.foci)
            path.steps.back().periods += made.periods;
        else
            path.steps.push_back(std::move(made));
    }
    return path;
}

}  // namespace haptogram
