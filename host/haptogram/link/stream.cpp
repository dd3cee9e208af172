// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/format/core.hpp"
#include "haptogram/link/focus_ring.hpp"
#include "haptogram/link/live_feed.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

template <class Entry, class Push>
Played feed(Commands& device, const StreamSettings& settings, SourceOf<Entry>& source, std::size_t foci_each,
            const Push& push, const Watch& watch) {
    Clock& clock = device.clock();
    const std::chrono::milliseconds pause = keep_alive_pause(settings.watchdog_ms);
    const Status before = device.status();
    Played played;
    Playing now{.status = before};
    const auto begun = clock.now();
    const auto learn = [&](const Status& status) {
        now.status = status;
        now.underruns = counted(before, status).underruns;
    };
    const auto go_on = [&] {
        now.seconds = clock.seconds_since(begun);
        now.sent = played.sent;
        if (!played.interrupted && watch && !watch(now)) played.interrupted = true;
        return !played.interrupted;
    };
    played.interrupted |= while_on(device, settings.watchdog_ms, [&] {
        LiveFeed fifo(device, device.identity(), foci_each);
        std::optional<Entry> entry;
        auto asked = clock.now();
        while (go_on()) {
            if (clock.now() - asked > pause) {
                learn(device.status());
                require_on(now.status, &before);
                asked = clock.now();
            }
            if (!entry) entry = source.next(pause);
            if (!entry && source.ended()) break;
            if (!entry || fifo.room() < fifo.frame()) {  // learning the FIFO's level also keeps the watchdog quiet
                if (entry && device.unanswered() == 0) clock.rest(std::chrono::milliseconds(1));
                fifo.refresh();
                continue;
            }
            std::vector<Entry> entries;
            while (entry && entries.size() < fifo.room() && (entries.empty() || entry->dwell == entries[0].dwell)) {
                entries.push_back(*entry);
                entry = source.next(std::chrono::milliseconds(0));
            }
            push(fifo, entries);
            played.sent += entries.size();
        }
        // Silence for good comes last: running out of indices would count as an underrun.
        while (go_on() && fifo.room() == 0) fifo.refresh();
        if (!played.interrupted) fifo.push({0}, 0);
        for (learn(sure_status(device)); go_on() && !is_over(now.status); learn(sure_status(device))) {
            require_on(now.status, &before);
            clock.rest(pause);
        }
    });
    Played all = counted(before, now.status);
    all.sent = played.sent;
    all.interrupted = played.interrupted;
    return all;
}

Played stream_entries(Commands& device, const StreamSettings& settings, StreamSource& source, const Watch& watch) {
    const auto push = [](LiveFeed& fifo, const std::vector<SequenceEntry>& entries) {
        std::vector<std::uint16_t> indices;
        for (const SequenceEntry& entry : entries) indices.push_back(entry.index);
        fifo.push(indices, entries[0].dwell);
    };
    return feed(device, settings, source, 0, push, watch);
}

/// Entries of an image whose focus records went over the link one by one, because the device's memory does not hold
/// them. Only the first was uploaded, which says where the channels are.
Played stream_records(Commands& device, const StreamSettings& settings, const FocusRecords& foci, StreamSource& source,
                      const Watch& watch) {
    const std::size_t each = make_ring(device).each;
    const auto push = [&](LiveFeed& fifo, const std::vector<SequenceEntry>& entries) {
        std::vector<std::uint16_t> words;
        for (const SequenceEntry& entry : entries) {
            // Silence is a record of amplitude 0, as an index of another kind would be a frame of its own.
            const std::size_t place = entry.index == 0 ? 0 : entry.index - foci.board_records - 1U;
            for (FocusWords focus : foci.record(place)) {
                if (entry.index == 0) focus[3] &= 0x003fU;
                words.insert(words.end(), focus.begin(), focus.end());
            }
        }
        fifo.push_foci(words, entries[0].dwell);
    };
    return feed(device, settings, source, each, push, watch);
}

/// Whether a device's memory holds so many focus records.
bool holds_records(const FocusRecords& foci, const Identity& identity) {
    return foci.count() <= Core{identity.name, identity.core()}.most_focus_records(foci.each);
}

}  // namespace

Played stream(Commands& device, const StreamSettings& settings, StreamSource& source, const Watch& watch) {
    if (settings.am.waveform.empty()) return stream_entries(device, settings, source, watch);
    const Modulation modulation = modulation_of(settings.am, device);
    if (device.identity().modulation_words == 0) {
        GatedEntries gated(source, gate_of(modulation, settings.am.waveform));
        return stream_entries(device, settings, gated, watch);
    }
    AmplitudesOnly checked(device, source);
    const ModulationOn on(device, modulation, settings.warn);
    return stream_entries(device, settings, checked, watch);
}

Played stream(Commands& device, const StreamSettings& settings, Image image, std::uint64_t loops,
              const std::string& where, const Progress& progress, const Watch& watch) {
    // The FIFO takes the sequence, and of foci the records, which may be longer than the device's memory. The sequence
    // that is there would play other records from now on.
    std::vector<SequenceEntry> entries = std::exchange(image.sequence, {});
    RepeatedEntries source(std::move(entries), loops);
    std::optional<FocusRecords> ringed;
    if (image.foci && !holds_records(*image.foci, device.identity())) {
        ringed = *image.foci;
        image.foci->foci.resize(image.foci->each);
    }
    require_fits(image, device.identity(), where);
    upload(device, image, progress);
    return ringed ? stream_records(device, settings, *ringed, source, watch) : stream(device, settings, source, watch);
}

Played stream(Commands& device, const StreamSettings& settings, FocusSource& source, const Watch& watch) {
    const std::size_t each = make_ring(device).each;
    const auto push = [each](LiveFeed& fifo, const std::vector<FocusEntry>& entries) {
        std::vector<std::uint16_t> words;
        for (const FocusEntry& entry : entries) add_record(words, entry.focus, each);
        fifo.push_foci(words, entries[0].dwell);
    };
    return feed(device, settings, source, each, push, watch);
}

std::uint16_t dwell_of(double rate, double carrier_hz) {
    constexpr double most = 65535.0;
    constexpr double tolerance = 0.05;
    const double cycles = std::clamp(std::round(carrier_hz / rate), 1.0, most);
    const double made = carrier_hz / cycles;
    if (std::abs(made - rate) > tolerance * rate)
        throw bad_argument(
            "rate", fmt::format("{} a second cannot be made of whole cycles at {:.0f} Hz; the nearest is {:.6g}", rate,
                                carrier_hz, made));
    return static_cast<std::uint16_t>(cycles);
}

}  // namespace haptogram::link
