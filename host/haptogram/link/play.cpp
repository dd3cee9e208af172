// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <set>
#include <thread>
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
                                           "cycles, expected 1 to 65535; about {:.3g} a second is most here",
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

}  // namespace

Played play(Commands& device, const PlaySettings& settings, const Watch& watch) {
    const bool live = settings.rate > 0.0 || (!settings.am.waveform.empty() && device.identity().modulation_words == 0);
    if (settings.on_trigger && (live || settings.index != 0))
        throw bad_argument("on-trigger",
                           "one record, and what goes over the link, cannot wait for a trigger; the sequence in the "
                           "board's memory can");
    if (live) return play_live(device, settings, wanted(device, settings), watch);
    using Clock = std::chrono::steady_clock;
    const Status before = device.status();
    std::uint16_t length = 0;
    if (settings.index == 0) {
        const Bytes header = device.read(interface::sequence_base, interface::sequence_word_bits / 8);
        length = static_cast<std::uint16_t>(interface::sequence_header_field::length.get(header));
        if (length == 0)
            throw Error(ErrorCode::device, "board",
                        "there is no sequence in the board's memory; upload an image first");
    }
    const auto since = [&](const Status& status, std::uint16_t Status::*counter) {
        return static_cast<std::uint16_t>(status.*counter - before.*counter);
    };
    Playing now{.status = before};
    bool interrupted = false;
    const std::optional<ModulationOn> modulation = modulated(device, settings);
    interrupted |= while_on(device, settings.watchdog_ms, [&] {
        if (settings.index != 0)
            device.select(settings.index);
        else
            device.start(1, settings.loops ? length : std::uint16_t{0}, settings.loops.value_or(0),
                         settings.on_trigger ? When::at_trigger() : When::at_once());
        auto begun = Clock::now();
        // A modulation that somebody else lets wait neither keeps this on nor stops its seconds.
        const auto waits = [&] { return settings.on_trigger && now.status.waiting; };
        // Asking for the status also keeps the watchdog quiet.
        const std::chrono::milliseconds pause = keep_alive_pause(settings.watchdog_ms);
        do {
            std::this_thread::sleep_for(pause);
            now.status = sure_status(device);
            if (waits()) begun = Clock::now();
            now.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
            now.underruns = since(now.status, &Status::underruns);
            interrupted = watch && !watch(now);
            require_on(now.status, &before);
        } while (!interrupted && (waits() || !is_over(now.status)) &&
                 (settings.seconds == 0.0 || now.seconds < settings.seconds));
    });
    return {.underruns = now.underruns,
            .refused_records = since(now.status, &Status::refused_records),
            .watchdog_trips = since(now.status, &Status::watchdog_trips),
            .guard_trips = since(now.status, &Status::guard_trips),
            .interrupted = interrupted};
}

}  // namespace haptogram::link
