// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/stream.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

constexpr std::uint16_t most_dwell = 65535;

/// A sequence with its dwells stretched so that a pass lasts 1 / rate.
std::vector<SequenceEntry> at_rate(std::vector<SequenceEntry> sequence, double rate, double carrier_hz) {
    double total = 0.0;
    for (const SequenceEntry& entry : sequence) total += entry.dwell;
    const double cycles = carrier_hz / rate;
    double before = 0.0;
    for (SequenceEntry& entry : sequence) {
        const double after = before + entry.dwell;
        const double dwell = std::round(cycles * after / total) - std::round(cycles * before / total);
        if (dwell < 1.0 || dwell > 65535.0)
            throw bad_argument("rate",
                               fmt::format("at {} passes a second an entry of the sequence would last {} carrier "
                                           "cycles, expected 1 to 65535; about {:.6g} a second is most here",
                                           rate, dwell, carrier_hz / static_cast<double>(sequence.size())));
        entry.dwell = static_cast<std::uint16_t>(dwell);
        before = after;
    }
    return sequence;
}

/// What is to be played, as entries and how often they are repeated.
DeviceSequence wanted(Commands& device, const PlaySettings& settings) {
    if (settings.index != 0) return {{{settings.index, most_dwell}}, 0};
    DeviceSequence sequence = download_sequence(device, "board");
    sequence.loops = settings.loops.value_or(sequence.loops);
    return sequence;
}

Played play_live(Commands& device, const PlaySettings& settings, DeviceSequence sequence, const Watch& watch) {
    const auto carried = std::ranges::find_if(sequence.entries, [](const SequenceEntry& e) { return e.index != 0; });
    if (carried == sequence.entries.end())
        throw Error(ErrorCode::device, "board", "the sequence in its memory plays no record");
    const double carrier_hz = record_carrier_hz(device, carried->index);
    if (settings.rate > 0.0) sequence.entries = at_rate(std::move(sequence.entries), settings.rate, carrier_hz);
    const double periods = settings.seconds > 0.0 ? std::max(1.0, std::round(settings.seconds * carrier_hz)) : 0.0;
    RepeatedEntries source(std::move(sequence.entries), sequence.loops, static_cast<std::uint64_t>(periods));
    StreamSettings live{settings.watchdog_ms, settings.warn, settings.am};
    live.am.carrier_hz = carrier_hz;
    return stream(device, live, source, watch);
}

/// Lets the device modulate what its memories play.
std::optional<ModulationOn> modulated(Commands& device, const PlaySettings& settings) {
    if (settings.am.waveform.empty()) return {};
    Am am = settings.am;
    std::set<std::uint16_t> indices;
    for (const SequenceEntry& entry : wanted(device, settings).entries)
        if (entry.index != 0) indices.insert(entry.index);
    for (const std::uint16_t index : indices) require_amplitudes(device, index);
    if (!indices.empty()) am.carrier_hz = record_carrier_hz(device, *indices.begin());
    return std::optional<ModulationOn>(std::in_place, device, modulation_of(am, device), settings.warn);
}

/// What is particular of playing what is in the memories.
struct FromMemories {
    std::function<void()> begin;                          ///< once the outputs are on
    std::function<void(std::chrono::milliseconds)> wait;  ///< so long at most
    std::function<bool(const Status&)> waits;             ///< whether its seconds have not begun
    std::function<bool(const Status&)> goes_on;
};

Played play_memories(Commands& device, const PlaySettings& settings, const Watch& watch, const FromMemories& what) {
    const Clock& clock = device.clock();
    const Status before = device.status();
    Playing now{.status = before};
    bool interrupted = false;
    const std::optional<ModulationOn> modulation = modulated(device, settings);
    interrupted |= while_on(device, settings.watchdog_ms, [&] {
        what.begin();
        auto begun = clock.now();
        // Asking for the status also keeps the watchdog quiet.
        const std::chrono::milliseconds pause = keep_alive_pause(settings.watchdog_ms);
        do {
            what.wait(pause);
            now.status = sure_status(device);
            if (what.waits(now.status)) begun = clock.now();
            now.seconds = clock.seconds_since(begun);
            now.underruns = counted(before, now.status).underruns;
            interrupted = watch && !watch(now);
            require_on(now.status, &before);
        } while (!interrupted && what.goes_on(now.status) &&
                 (settings.seconds == 0.0 || now.seconds < settings.seconds));
    });
    Played played = counted(before, now.status);
    played.interrupted = interrupted;
    return played;
}

}  // namespace

std::uint16_t sequence_length(Commands& device) {
    const Bytes header = device.read(interface::sequence_base, interface::sequence_word_bits / 8);
    const auto length = static_cast<std::uint16_t>(interface::sequence_header_field::length.get(header));
    if (length == 0)
        throw Error(ErrorCode::device, "board", "there is no sequence in the board's memory; upload an image first");
    return length;
}

Played play(Commands& device, const PlaySettings& settings, const Watch& watch) {
    const bool live = settings.rate > 0.0 || (!settings.am.waveform.empty() && device.identity().modulation_words == 0);
    if (settings.on_trigger && (live || settings.index != 0))
        throw bad_argument("on-trigger",
                           "one record, and what goes over the link, cannot wait for a trigger; the sequence in the "
                           "board's memory can");
    if (live) return play_live(device, settings, wanted(device, settings), watch);
    const std::uint16_t length = settings.index == 0 ? sequence_length(device) : std::uint16_t{0};
    // A modulation that somebody else lets wait neither keeps this on nor stops its seconds.
    const auto waits = [&](const Status& status) { return settings.on_trigger && status.waiting; };
    return play_memories(device, settings, watch,
                         {.begin =
                              [&] {
                                  if (settings.index != 0)
                                      device.select(settings.index);
                                  else
                                      device.start(1, settings.loops ? length : std::uint16_t{0},
                                                   settings.loops.value_or(0),
                                                   settings.on_trigger ? When::at_trigger() : When::at_once());
                              },
                          .wait = [&device](std::chrono::milliseconds pause) { device.clock().rest(pause); },
                          .waits = waits,
                          .goes_on = [&](const Status& status) { return waits(status) || !is_over(status); }});
}

Played play(Commands& device, const PlaySettings& settings, std::span<const TriggeredPart> parts, TriggerSource& source,
            const Watch& watch) {
    if (!settings.am.waveform.empty() && device.identity().modulation_words == 0)
        throw bad_argument("am",
                           "this board has no modulation of its own, and what waits for triggers in its memory "
                           "can have no other; compile the waveform into the image");
    require_parts(parts, sequence_length(device), device.identity());
    constexpr std::chrono::milliseconds pin_pause{20};
    const TriggeredPart* pin = part_of_pin(parts);
    const auto start = [&device](const TriggeredPart& part, When when) {
        device.start(part.first, part.length, part.loops, when);
    };
    const auto begin = [&] {
        if (pin != nullptr) start(*pin, When::at_trigger());
    };
    const auto wait = [&](std::chrono::milliseconds pause) {
        if (const auto fired = source.next(pin != nullptr ? std::min(pause, pin_pause) : pause))
            start(parts[*fired], When::at_once());
    };
    const auto goes_on = [&](const Status& status) {
        if (pin != nullptr && !status.waiting) start(*pin, When::at_trigger());
        return pin != nullptr || !source.ended() || !is_over(status);
    };
    return play_memories(
        device, settings, watch,
        {.begin = begin, .wait = wait, .waits = [](const Status&) { return false; }, .goes_on = goes_on});
}

}  // namespace haptogram::link
