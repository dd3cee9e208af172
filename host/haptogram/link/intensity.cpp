// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/intensity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/timer.hpp"
#include "haptogram/link/memory.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

constexpr std::uint32_t word_bytes = 2;
constexpr std::uint32_t pulse_word = 1;  // of a record: the pulse's length, and the cycle's upper bits

bool is_timings(const Record& record) { return record.kind == interface::Kind::timings; }

}  // namespace

bool can_be_modulated(const Image& image) {
    return image.foci.has_value() || !std::ranges::all_of(image.records, is_timings);
}

Intensity::Intensity(Image image) : image_(std::move(image)), has_amplitudes_(can_be_modulated(image_)) {
    for (const Record& record : image_.records) pulses_.push_back(is_timings(record) ? record.pulse_length : 0);
}

void Intensity::set(Commands& device, double factor) {
    if (!(factor >= 0.0 && factor <= 1.0))
        throw bad_argument("intensity", fmt::format("found {}, expected 0 to 1", factor));
    if (has_amplitudes_) require_modulation(device);
    factor_ = factor;
    set_pulses(device, factor);
    if (has_amplitudes_) set_samples(device, false);
}

void Intensity::modulate(Commands& device, const std::optional<SampledModulation>& modulation) {
    if (!has_amplitudes_)
        throw bad_input("image", "it has timings and no amplitudes that the board could modulate; play it anew");
    require_modulation(device);
    const std::size_t most = std::size_t{2} * device.identity().modulation_words;
    if (modulation && modulation->samples.size() > most)
        throw bad_input("modulation",
                        fmt::format("it has {} samples; the board holds {}", modulation->samples.size(), most));
    image_.modulation = modulation;
    set_samples(device, true);
}

void Intensity::require_modulation(Commands& device) const {
    if (device.identity().modulation_words == 0)
        throw bad_input("board",
                        "it holds amplitudes, and has no modulation by which they could become weaker; compile "
                        "with another amplitude");
}

void Intensity::set_pulses(Commands& device, double factor) {
    const std::uint32_t least_clocks = std::max(device.identity().min_pulse_clocks, 1U);
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < image_.records.size(); ++i) {
        const Record& record = image_.records[i];
        if (!is_timings(record)) continue;
        const Timer timer{static_cast<double>(image_.clock_hz), record.prescaler, record.cycle_length,
                          record.pulse_length, (least_clocks + record.prescaler - 1) / record.prescaler};
        const std::uint32_t pulse = pulse_ticks(timer, factor);
        if (pulse == pulses_[i]) continue;
        std::array<std::uint16_t, interface::record_header_words> header{};
        interface::record_field::cycle_length.set(header, record.cycle_length);
        interface::record_field::pulse_length.set(header, pulse);
        const std::uint32_t word = static_cast<std::uint32_t>(i) * record_words(image_.channels) + pulse_word;
        pieces.push_back(
            {interface::primary_base + word_bytes * word,
             {static_cast<std::uint8_t>(header[pulse_word]), static_cast<std::uint8_t>(header[pulse_word] >> 8)}});
        pulses_[i] = pulse;
    }
    device.pipeline(writing(pieces));
}

/// @param anew  from the first sample on, and with another divider; otherwise samples that play go on
void Intensity::set_samples(Commands& device, bool anew) const {
    Image weaker;
    weaker.channels = image_.channels;
    weaker.modulation = image_.modulation.value_or(SampledModulation{1, {255, 255}});
    for (std::uint8_t& sample : weaker.modulation->samples)
        sample = static_cast<std::uint8_t>(std::lround(factor_ * sample));
    // Samples that a device plays may change while it does; it goes on where it is in its loop.
    write_settings(device, weaker);
    if (anew || !device.status().modulated) start_modulation(device, weaker);
}

}  // namespace haptogram::link
