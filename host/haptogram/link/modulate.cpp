// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/modulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

Bytes record_header(Commands& device, std::uint16_t index) {
    const std::uint32_t place = 2 * record_words(device.identity().channels) * (index - 1U);
    return device.read(interface::primary_base + place, 2 * interface::record_header_words);
}

bool is_focus(const Commands& device, std::uint16_t index) {
    return device.identity().foci > 0 && index > device.identity().records;
}

}  // namespace

Modulation modulation_of(const Am& am, Commands& device) {
    constexpr std::size_t most_without_memory = 4096;
    const std::uint32_t held = 2 * device.identity().modulation_words;
    const double carrier_hz = am.carrier_hz > 0.0 ? am.carrier_hz : device_carrier_hz(device);
    return haptogram::modulation_of(am.waveform, am.law, carrier_hz, {}, held > 0 ? held : most_without_memory)
        .modulation;
}

double record_carrier_hz(Commands& device, std::uint16_t index) {
    const Identity& identity = device.identity();
    if (is_focus(device, index)) {
        const auto bytes = static_cast<std::uint16_t>(2 * interface::parameters_words);
        const double clocks =
            interface::parameters_field::foci_cycle.get(device.read(interface::parameters_base, bytes));
        if (clocks == 0.0) throw Error(ErrorCode::device, "board", "its foci have no carrier; upload an image first");
        return identity.clock_hz / clocks;
    }
    const Bytes header = record_header(device, index);
    const double cycle = interface::record_field::cycle_length.get(header);
    const double prescaler = interface::record_field::prescaler.get(header);
    if (cycle == 0.0 || prescaler == 0.0)
        throw Error(ErrorCode::device, "board",
                    fmt::format("record {} in its memory has no carrier; upload an image first", index));
    return identity.clock_hz / (cycle * prescaler);
}

double device_carrier_hz(Commands& device) {
    const std::uint32_t records = device.identity().records;
    return record_carrier_hz(device, static_cast<std::uint16_t>(highest_index(device) > records ? records + 1 : 1));
}

void require_amplitudes(Commands& device, std::uint16_t index) {
    if (is_focus(device, index)) return;
    const auto kind = static_cast<interface::Kind>(interface::record_field::kind.get(record_header(device, index)));
    if (kind != interface::Kind::timings) return;
    throw bad_input(fmt::format("record {}", index),
                    "it has timings and no amplitudes that the board could modulate; compile it as foci, or with the "
                    "waveform itself",
                    {"am", "foci"});
}

ModulationOn::ModulationOn(Commands& device, const Modulation& modulation, Warning warn)
    : device_(device), warn_(std::move(warn)) {
    const Identity& identity = device.identity();
    Image image;  // that has nothing else
    image.channels = identity.channels;
    image.modulation = sampled(modulation, 2 * identity.modulation_words, "board");
    write_settings(device, image);
    start_modulation(device, image);
}

ModulationOn::~ModulationOn() {
    try {
        device_.modulate(0, 0, false);
    } catch (const Error& error) {
        if (error.code() == ErrorCode::cancelled || !warn_) return;
        try {
            warn_(fmt::format("{}; the board still modulates what it plays, until the next upload", error.what()));
        } catch (const std::exception&) {
            // A warning that cannot be given must not end the program while it cleans up.
        }
    }
}

Gate gate_of(const Modulation& modulation, const std::string& name) {
    const std::vector<double>& samples = modulation.samples;
    const auto neighbour = [&](std::size_t i, std::size_t step) { return samples[(i + step) % samples.size()]; };
    Gate gate{{0}};
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double before = neighbour(i, samples.size() - 1), after = neighbour(i, 1);
        const bool whole = samples[i] == 0.0 || samples[i] == 1.0;
        const bool edge = std::min(before, after) == 0.0 && std::max(before, after) == 1.0;
        if (!whole && !edge)
            throw bad_argument("am", fmt::format("the board does not modulate, so silence between its records can only "
                                                 "make waveforms that are on or off, such as square:200, not {}; "
                                                 "compile with it, or stream a path with it",
                                                 name));
        const bool on = samples[i] >= 0.5;
        if (on != (gate.periods.size() % 2 == 1)) gate.periods.push_back(0);
        gate.periods.back() += modulation.periods_a_sample;
    }
    if (gate.periods.size() % 2 == 1) gate.periods.push_back(0);
    return gate;
}

std::optional<SequenceEntry> GatedEntries::next(std::chrono::milliseconds patience) {
    if (!entry_) entry_ = source_.next(patience);
    if (!entry_) return {};
    if (entry_->dwell == 0)
        throw bad_input("dwell 0", "an entry that lasts until the next one cannot be modulated; give it a dwell");
    while (past_ == gate_.periods[at_]) {
        at_ = (at_ + 1) % gate_.periods.size();
        past_ = 0;
    }
    const auto dwell = static_cast<std::uint16_t>(std::min<std::uint64_t>(entry_->dwell, gate_.periods[at_] - past_));
    const SequenceEntry now{at_ % 2 == 0 ? entry_->index : std::uint16_t{0}, dwell};
    past_ += dwell;
    entry_->dwell = static_cast<std::uint16_t>(entry_->dwell - dwell);
    if (entry_->dwell == 0) entry_.reset();
    return now;
}

std::optional<SequenceEntry> AmplitudesOnly::next(std::chrono::milliseconds patience) {
    const std::optional<SequenceEntry> entry = source_.next(patience);
    if (!entry || entry->index == 0) return entry;
    known_.resize(std::max<std::size_t>(known_.size(), entry->index + std::size_t{1}));
    if (!known_[entry->index]) require_amplitudes(device_, entry->index);
    known_[entry->index] = true;
    return entry;
}

}  // namespace haptogram::link
