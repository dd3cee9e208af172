// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/link/stream.hpp"
#include "haptogram/link/transfer.hpp"

namespace haptogram::link {
namespace {

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

/// A sequence that is repeated until so many entries were taken; 0: for ever.
class Repeated final : public StreamSource {
public:
    Repeated(std::vector<SequenceEntry> pass, std::uint64_t entries) : pass_(std::move(pass)), entries_(entries) {}
    std::optional<SequenceEntry> next(std::chrono::milliseconds) override {
        if (ended()) return {};
        return pass_[taken_++ % pass_.size()];
    }
    [[nodiscard]] bool ended() const override { return entries_ != 0 && taken_ == entries_; }

private:
    std::vector<SequenceEntry> pass_;
    std::uint64_t entries_, taken_ = 0;
};

Played play_at_rate(Commands& device, const PlaySettings& settings, const Watch& watch) {
    const DeviceSequence sequence = download_sequence(device, "board");
    const auto carried = std::ranges::find_if(sequence.entries, [](const SequenceEntry& e) { return e.index != 0; });
    if (carried == sequence.entries.end())
        throw Error(ErrorCode::device, "board", "the sequence in its memory plays no record");
    std::vector<SequenceEntry> pass =
        at_rate(sequence.entries, settings.rate, record_carrier_hz(device, carried->index));
    const std::uint64_t passes = settings.loops.value_or(sequence.loops);
    std::uint64_t entries = passes * pass.size();
    if (settings.seconds > 0.0) {
        const auto most = static_cast<std::uint64_t>(
            std::max(1.0, std::round(settings.seconds * settings.rate * static_cast<double>(pass.size()))));
        entries = entries == 0 ? most : std::min(entries, most);
    }
    Repeated source(std::move(pass), entries);
    return stream(device, {settings.watchdog_ms, settings.warn}, source, watch);
}

}  // namespace

Played play(Commands& device, const PlaySettings& settings, const Watch& watch) {
    if (settings.rate > 0.0) return play_at_rate(device, settings, watch);
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
    {
        const Outputs on(device, settings.watchdog_ms, settings.warn);
        if (settings.index != 0)
            device.select(settings.index);
        else
            device.start(1, settings.loops ? length : std::uint16_t{0}, settings.loops.value_or(0));
        const auto begun = Clock::now();
        // Asking for the status also keeps the watchdog quiet.
        const std::chrono::milliseconds pause = keep_alive_pause(settings.watchdog_ms);
        do {
            std::this_thread::sleep_for(pause);
            now.status = device.status();
            now.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
            now.underruns = since(now.status, &Status::underruns);
            interrupted = watch && !watch(now);
            require_on(now.status);
        } while (!interrupted && (now.status.mode != Mode::idle || now.status.present_index != 0) &&
                 (settings.seconds == 0.0 || now.seconds < settings.seconds));
    }
    return {.underruns = now.underruns,
            .refused_records = since(now.status, &Status::refused_records),
            .watchdog_trips = since(now.status, &Status::watchdog_trips),
            .guard_trips = since(now.status, &Status::guard_trips),
            .interrupted = interrupted};
}

double record_carrier_hz(Commands& device, std::uint16_t index) {
    const Identity& identity = device.identity();
    if (identity.foci > 0 && index > identity.records) {
        const auto bytes = static_cast<std::uint16_t>(2 * interface::parameters_words);
        const double clocks =
            interface::parameters_field::foci_cycle.get(device.read(interface::parameters_base, bytes));
        if (clocks == 0.0) throw Error(ErrorCode::device, "board", "its foci have no carrier; upload an image first");
        return identity.clock_hz / clocks;
    }
    const std::uint32_t place = 2 * record_words(identity.channels) * (index - 1U);
    const Bytes header = device.read(interface::primary_base + place, 2 * interface::record_header_words);
    const double cycle = interface::record_field::cycle_length.get(header);
    const double prescaler = interface::record_field::prescaler.get(header);
    if (cycle == 0.0 || prescaler == 0.0)
        throw Error(ErrorCode::device, "board",
                    fmt::format("record {} in its memory has no carrier; upload an image first", index));
    return identity.clock_hz / (cycle * prescaler);
}

}  // namespace haptogram::link
