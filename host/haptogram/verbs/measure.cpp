// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/measure.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/base/error.hpp"

namespace haptogram {
namespace {

/// One channel's pulses, in order, cut into stretches of one record each.
template <class Visit>
void for_each_stretch(const std::vector<Pulse>& pulses, Visit visit) {
    for (std::size_t begin = 0; begin < pulses.size();) {
        std::size_t end = begin;
        while (end < pulses.size() && pulses[end].index == pulses[begin].index) ++end;
        const std::span<const Pulse> stretch(pulses.data() + begin, end - begin);
        visit(stretch, stretch.size() >= 3 ? stretch.subspan(1, stretch.size() - 2) : stretch);
        begin = end;
    }
}

}  // namespace

std::size_t place_of(const Manifest& manifest, const Pulse& pulse, const std::string& where) {
    if (const auto place = manifest.place_of(pulse.index)) return *place;
    throw bad_input(where, fmt::format("a pulse of record {}, but the manifest has {} from {} on; these pulses are "
                                       "another image's",
                                       pulse.index, manifest.records.size(), manifest.index_of(0)));
}

std::vector<MeasuredRecord> measure(const Manifest& manifest, const std::vector<Pulse>& pulses,
                                    const std::string& where) {
    const std::size_t elements = manifest.array.elements.size();
    std::vector<std::vector<Pulse>> by_channel(elements);
    for (const Pulse& pulse : pulses) {
        if (pulse.channel >= elements)
            throw bad_input(
                where,
                fmt::format("a pulse on channel {}, but the array has {} elements; these pulses are another array's",
                            pulse.channel, elements));
        (void)place_of(manifest, pulse, where);
        by_channel[pulse.channel].push_back(pulse);
    }
    const double clock_s = 1.0 / manifest.timer.clock_hz;
    const double period_s = manifest.timer.period_s();
    std::vector<MeasuredRecord> records(manifest.records.size());
    for (auto& record : records) {
        record.drives.resize(elements);
        record.root_mean_square.resize(elements);
    }
    // `cycles` counts all of the time that a record played. Its drives are the mean of the pulses that were not left
    // out.
    for (std::size_t channel = 0; channel < elements; ++channel) {
        std::vector<std::uint64_t> cycles(records.size());
        std::vector<std::uint64_t> measured(records.size());
        std::vector<double> squares(records.size());
        for_each_stretch(by_channel[channel], [&](std::span<const Pulse> stretch, std::span<const Pulse> inner) {
            std::vector<DrivePulse> train;
            for (const Pulse& p : inner)
                train.push_back({static_cast<double>(p.rise) * clock_s, static_cast<double>(p.fall) * clock_s});
            const std::size_t r = place_of(manifest, stretch.front(), where);
            // A record may play in several stretches, and each counts by its length.
            records[r].drives[channel] += carrier_component(train, manifest.timer.carrier_hz(), period_s);
            for (const DrivePulse& one : train)
                squares[r] += std::norm(carrier_component({&one, 1}, manifest.timer.carrier_hz(), period_s));
            cycles[r] += stretch.size();
            measured[r] += inner.size();
        });
        for (std::size_t r = 0; r < records.size(); ++r) {
            if (measured[r] > 0) {
                const double source = manifest.array.transducer.source_pa_m;
                std::complex<double>& drive = records[r].drives[channel];
                drive *= source / static_cast<double>(measured[r]);
                const double size = source * std::sqrt(squares[r] / static_cast<double>(measured[r]));
                records[r].root_mean_square[channel] = std::polar(size, std::arg(drive));
            }
            records[r].cycles = std::max(records[r].cycles, cycles[r]);
        }
    }
    return records;
}

std::vector<std::complex<double>> drives_of(const Manifest& manifest, const Record& record) {
    const double tick_s = record.prescaler / manifest.timer.clock_hz;
    const double period_s = record.cycle_length * tick_s;
    std::vector<std::complex<double>> drives;
    for (std::size_t m = 0; m < manifest.array.elements.size(); ++m) {
        const std::uint16_t tick = record.timings.at(m);
        const DrivePulse pulse{tick * tick_s, (tick + record.pulse_length) * tick_s};
        drives.push_back(record.fires(m) ? manifest.array.transducer.source_pa_m *
                                               carrier_component({&pulse, 1}, 1.0 / period_s, period_s)
                                         : 0.0);
    }
    return drives;
}

std::vector<std::complex<double>> drives_of(const Manifest& manifest, const Image& image, std::size_t place,
                                            std::uint8_t sample) {
    if (!has_amplitudes(image, place)) return drives_of(manifest, image.records[place]);
    const double tick_s = 1.0 / image.clock_hz;
    const auto cycle = static_cast<std::uint32_t>(cycle_clocks(image, place));
    const double period_s = cycle * tick_s;
    const std::vector<EmissionWord> words = emission_words(image, emissions_of(image, place), cycle, sample);
    std::vector<std::complex<double>> drives;
    for (std::size_t m = 0; m < manifest.array.elements.size(); ++m) {
        const DrivePulse pulse{words.at(m).rise * tick_s, (words.at(m).rise + words.at(m).width) * tick_s};
        drives.push_back(words[m].width > 0 ? manifest.array.transducer.source_pa_m *
                                                  carrier_component({&pulse, 1}, 1.0 / period_s, period_s)
                                            : 0.0);
    }
    return drives;
}

}  // namespace haptogram
