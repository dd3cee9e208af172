// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/intensity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

constexpr std::uint32_t word_bytes = 2;
constexpr std::uint32_t pulse_word = 1;  // of a record: the pulse's length, and the cycle's upper bits

bool is_timings(const Record& record) { return record.kind == interface::Kind::timings; }

void require_modulation(const Identity& identity) {
    if (identity.modulation_words == 0)
        throw bad_input("board",
                        "it holds amplitudes, and has no modulation by which they could become weaker; compile "
                        "with another amplitude");
}

}  // namespace

bool can_be_modulated(const Image& image) {
    return image.foci.has_value() || !std::ranges::all_of(image.records, is_timings);
}

Intensity::Intensity(Image image) : image_(std::move(image)), has_amplitudes_(can_be_modulated(image_)) {
    for (const Record& record : image_.records) pulses_.push_back(is_timings(record) ? record.pulse_length : 0);
}

void Intensity::set(Commands& device, double factor) {
    device.pipeline(requests(device.identity(), has_amplitudes_ && device.status().modulated, factor));
}

std::vector<Request> Intensity::requests(const Identity& identity, bool modulates, double factor) {
    if (!(factor >= 0.0 && factor <= 1.0))
        throw bad_argument("intensity", fmt::format("found {}, expected 0 to 1", factor));
    if (has_amplitudes_) require_modulation(identity);
    factor_ = factor;
    std::vector<Request> requests;
    add_pulses(requests, identity, factor);
    // Samples that a device plays may change while it does; it goes on where it is in its loop.
    if (has_amplitudes_) add_samples(requests, identity, !modulates);
    return requests;
}

void Intensity::modulate(Commands& device, const std::optional<SampledModulation>& modulation) {
    device.pipeline(requests(device.identity(), modulation));
}

std::vector<Request> Intensity::requests(const Identity& identity, const std::optional<SampledModulation>& modulation) {
    if (!has_amplitudes_)
        throw bad_input("image", "it has timings and no amplitudes that the board could modulate; play it anew");
    require_modulation(identity);
    const std::size_t most = std::size_t{2} * identity.modulation_words;
    if (modulation && modulation->samples.size() > most)
        throw bad_input("modulation",
                        fmt::format("it has {} samples; the board holds {}", modulation->samples.size(), most));
    image_.modulation = modulation;
    std::vector<Request> requests;
    add_samples(requests, identity, true);
    return requests;
}

void Intensity::add_pulses(std::vector<Request>& requests, const Identity& identity, double factor) {
    const std::uint32_t least_clocks = std::max(identity.min_pulse_clocks, 1U);
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
        requests.push_back(write_request(interface::primary_base + word_bytes * word, {&header[pulse_word], 1}));
        pulses_[i] = pulse;
    }
}

/// @param starts  whether the samples are played from the first on, and with the image's divider
void Intensity::add_samples(std::vector<Request>& requests, const Identity& identity, bool starts) const {
    Image weaker;
    weaker.channels = image_.channels;
    weaker.modulation = image_.modulation.value_or(SampledModulation{1, {255, 255}});
    for (std::uint8_t& sample : weaker.modulation->samples)
        sample = static_cast<std::uint8_t>(std::lround(factor_ * sample));
    std::ranges::move(settings_requests(weaker), std::back_inserter(requests));
    if (!starts) return;
    if (std::optional<Request> start = modulation_request(weaker, identity)) requests.push_back(std::move(*start));
}

}  // namespace haptogram::link
