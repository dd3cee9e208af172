// SPDX-License-Identifier: Apache-2.0
// The checks that need nobody: link, memories, clock, sync, outputs, watchdog.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/kept_memory.hpp"
#include "haptogram/verbs/self_test_checks.hpp"

namespace haptogram::link {
namespace {

/// Two numbers for every word of memory, by its address: neighbours differ in half of their bits, so that a wrong
/// address line shows, and the second is the complement, so that each bit is seen as 0 and as 1.
std::uint16_t pattern_at(std::uint32_t address, bool complement) {
    std::uint32_t bits = address * 0x9E3779B1U;  // Knuth's multiplicative hash
    bits ^= bits >> 15U;
    bits *= 0x85EBCA77U;
    const auto word = static_cast<std::uint16_t>(bits >> 13U);
    return complement ? static_cast<std::uint16_t>(~word) : word;
}

/// The memories that can be written and read back.
std::vector<Stretch> memories_of(const Identity& identity) {
    std::vector<Stretch> memories = {
        {interface::primary_base, std::size_t{2} * identity.records * record_words(identity.channels)},
        {interface::sequence_base, std::size_t{4} * identity.sequence_depth}};
    if (identity.modulation_words > 0)
        memories.push_back({interface::modulation_base, std::size_t{2} * identity.modulation_words});
    return memories;
}

std::vector<Piece> pattern_of(const std::vector<Stretch>& memories, std::size_t frame, bool complement) {
    std::vector<Piece> pieces;
    for (const Stretch& memory : memories) {
        std::vector<std::uint16_t> words(memory.bytes / 2);
        for (std::size_t i = 0; i < words.size(); ++i)
            words[i] = pattern_at(memory.address + static_cast<std::uint32_t>(2 * i), complement);
        cut(pieces, memory.address, words, frame);
    }
    return pieces;
}

/// For how long the board played, as far as a host can know that sends a command, waits for its answer, and asks.
struct Duration {
    double least_s = 0.0, most_s = std::numeric_limits<double>::infinity();
};

/// Plays silence, so many cycles of record 1, and sees when the board has ended it.
Duration play_silence(Commands& device, std::uint16_t cycles, double give_up_s, const Progress& progress) {
    Clock& clock = device.clock();
    const Clock::Time asked = clock.now();
    device.select(1, cycles);
    const Clock::Time begun = clock.now();
    Duration lasted;
    while (clock.seconds_since(begun) < give_up_s) {
        const Clock::Time before = clock.now();
        const Status status = sure_status(device);
        require_on(status);
        if (is_over(status)) {
            lasted.most_s = clock.seconds_since(asked);
            break;
        }
        lasted.least_s = Clock::seconds(before - begun);
        progress(std::min(1.0, lasted.least_s / give_up_s));
        clock.rest(std::chrono::milliseconds(1));
    }
    return lasted;
}

}  // namespace

Finding check_link(Commands& device, const SelfTestSettings& settings) {
    constexpr int singles = 20, together = 100;
    const Progress progress = settings.progress.in_stage(to_string(Check::link));
    const Clock& clock = device.clock();
    const Status before = device.status();
    const std::uint64_t sent_before = device.retransmissions();
    std::vector<double> trips;
    for (int i = 0; i < singles; ++i) {
        const Clock::Time begun = clock.now();
        device.keep_alive();
        trips.push_back(clock.seconds_since(begun));
        progress(0.5 * i / singles);
    }
    std::ranges::nth_element(trips, trips.begin() + singles / 2);
    const Request ask =
        asking(interface::Command::read, {interface::identity_base, Bytes(2 * interface::identity_words)});
    for (const Reply& reply : device.pipeline(std::vector<Request>(together, ask), progress.between(0.5, 1.0)))
        if (to_identity(reply.data) != device.identity())
            return {Check::link, Outcome::failed, "the board says of itself another thing each time",
                    "switch it off and on; then see cable, ground and baud rate"};
    const auto damaged = static_cast<std::uint16_t>(device.status().frames_damaged - before.frames_damaged);
    const std::uint64_t again = device.retransmissions() - sent_before;
    const std::string found = fmt::format("{} frames there and back, {:.2f} ms each way and back when sent singly",
                                          singles + together, 1e3 * trips[singles / 2]);
    if (damaged == 0 && again == 0) return {Check::link, Outcome::passed, found + ", none lost"};
    return {Check::link, Outcome::failed, fmt::format("{}, {} damaged, {} sent again", found, damaged, again),
            "what is lost is sent again, so all still works, only slower; see the cable's length and its ground, and "
            "try a lower baud rate"};
}

Finding check_memories(Commands& device, const SelfTestSettings& settings) {
    const Progress progress = settings.progress.in_stage(to_string(Check::memories));
    const std::vector<Stretch> memories = memories_of(device.identity());
    const std::size_t frame = std::size_t{2} * record_words(device.identity().channels) / 4 * 4;
    std::size_t bytes = 0;
    for (const Stretch& memory : memories) bytes += memory.bytes;
    const KeptMemory kept(device, memories, settings.warn, progress.between(0.0, 0.25));
    for (const bool complement : {false, true}) {
        const std::vector<Piece> pattern = pattern_of(memories, frame, complement);
        const double at = complement ? 0.55 : 0.25;
        device.pipeline(writing(pattern), progress.between(at, at + 0.25));
        const std::vector<Piece> wrong = differing(device, pattern, progress.between(at + 0.25, at + 0.3));
        if (!wrong.empty())
            return {Check::memories, Outcome::failed,
                    fmt::format("of {} pieces {} differ from the pattern that was written, the first from address "
                                "{:#010x} on",
                                pattern.size(), wrong.size(), wrong.front().address),
                    "load the bitstream anew; if it stays so, build it with another seed: the timing report must say "
                    "that it is fast enough for the board's clock"};
    }
    return {Check::memories, Outcome::passed,
            fmt::format("{} bytes, each bit as 0 and as 1, by the board's own digests", bytes)};
}

Finding check_clock(Commands& device, const SelfTestSettings& settings) {
    constexpr std::uint16_t cycles = 65535;
    constexpr double patience = 5.0, tolerance = 0.005;
    const Identity& identity = device.identity();
    const Image image = pulsing_image(identity, settings.array,
                                      std::vector<std::uint16_t>(identity.channels, interface::silent_timing));
    const KeptMemory kept(device, {{interface::primary_base, std::size_t{2} * record_words(identity.channels)}},
                          settings.warn);
    std::vector<Piece> record;
    cut(record, interface::primary_base, primary_words(image), std::size_t{2} * record_words(identity.channels));
    device.pipeline(writing(record));
    const double nominal_s = static_cast<double>(cycle_clocks(image, 0)) * cycles / identity.clock_hz;
    Duration lasted;
    constexpr std::uint16_t watchdog_ms = 500;
    heed(while_on(device, watchdog_ms, [&] {
        lasted =
            play_silence(device, cycles, patience * nominal_s, settings.progress.in_stage(to_string(Check::clock)));
    }));
    const double least_hz = identity.clock_hz * nominal_s / lasted.most_s;
    const double most_hz =
        lasted.least_s > 0.0 ? identity.clock_hz * nominal_s / lasted.least_s : std::numeric_limits<double>::infinity();
    const std::string found = fmt::format("between {:.4g} and {:.4g} MHz by this machine's clock, {:.4g} MHz asked",
                                          1e-6 * least_hz, 1e-6 * most_hz, 1e-6 * identity.clock_hz);
    if (least_hz <= identity.clock_hz * (1.0 + tolerance) && most_hz >= identity.clock_hz * (1.0 - tolerance))
        return {Check::clock, Outcome::passed, found};
    return {Check::clock, Outcome::failed, found,
            "the bitstream was built for another crystal, and all its times and the carrier are off by as much; a "
            "board that is simulated clock by clock is slower than real time, and fails here, too"};
}

Finding check_sync(Commands& device, const SelfTestSettings&) {
    if (device.identity().core().sync == 0) return {Check::sync, Outcome::unjudged, "this board has no SYNC"};
    const Status status = device.status();
    switch (status.role) {
        case Role::alone: return {Check::sync, Outcome::unjudged, "it keeps its own time; see `haptogram device sync`"};
        case Role::master:
            return {Check::sync, Outcome::unjudged, "it gives the time; ask its slaves whether they hear it"};
        case Role::slave: break;
    }
    if (status.in_step && status.numbered)
        return {Check::sync, Outcome::passed, fmt::format("in step, {} edges missed so far", status.sync_misses)};
    return {Check::sync, Outcome::failed,
            status.in_step ? "in step, but it does not know the number of the period"
                           : "not in step: no edges of SYNC arrive, or not in time",
            "see that one board is the master, and the wire from its sync_out to this board's sync_in, with a common "
            "ground; a function generator in its place gives no numbers"};
}

Finding check_outputs(Commands& device, const SelfTestSettings&) {
    constexpr std::uint16_t watchdog_ms = 0;  // silence plays
    bool came_on = false;
    heed(while_on(device, watchdog_ms, [&] { came_on = device.status().enabled; }));
    if (came_on && !device.status().enabled)
        return {Check::outputs, Outcome::passed, "on when they were enabled, off when they were disabled"};
    return {Check::outputs, Outcome::failed,
            came_on ? "still on after they were disabled" : "not on after they were enabled",
            "switch the board's power off and on; if it stays so, load the bitstream anew"};
}

Finding check_watchdog(Commands& device, const SelfTestSettings&) {
    constexpr std::uint16_t watchdog_ms = 50;
    const Status before = device.status();
    bool went_off = false;
    heed(while_on(device, watchdog_ms, [&] {
        device.keep_alive_every({});
        for (const int silence_ms : {200, 1000, 5000}) {  // a simulated board is slower than real time
            device.clock().rest(std::chrono::milliseconds(silence_ms));
            const Status status = device.status();
            went_off =
                static_cast<std::uint16_t>(status.watchdog_trips - before.watchdog_trips) == 1 && !status.enabled;
            if (went_off) break;
        }
    }));
    if (went_off)
        return {Check::watchdog, Outcome::passed, fmt::format("off by itself after a silence of {} ms", watchdog_ms)};
    return {Check::watchdog, Outcome::failed, fmt::format("the outputs stay on, {} ms of silence or not", watchdog_ms),
            "do not put a hand above this board: it would go on when its host dies. Does another program speak to it? "
            "If not, load the bitstream anew"};
}

}  // namespace haptogram::link
