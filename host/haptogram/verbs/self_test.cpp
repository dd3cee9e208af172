// SPDX-License-Identifier: Apache-2.0
// The checks that need nobody: link, memories, clock, sync, outputs, watchdog.
// The checks that a person judges: the stop switch, which transducers are silent, and whether a point is felt.
#include "haptogram/verbs/self_test.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/link/kept_memory.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "haptogram/verbs/self_test_checks.hpp"

namespace haptogram::link {
namespace {

struct Named {
    Check check;
    std::string_view name;
    Finding (*run)(Commands&, const SelfTestSettings&);
    bool needs_outputs;  ///< it cannot be done while the stop input is active
};

constexpr std::array<Named, all_checks.size()> checks = {{
    {Check::link, "link", check_link, false},
    {Check::memories, "memories", check_memories, false},
    {Check::clock, "clock", check_clock, true},
    {Check::sync, "sync", check_sync, false},
    {Check::outputs, "outputs", check_outputs, true},
    {Check::watchdog, "watchdog", check_watchdog, true},
    {Check::stop_switch, "stop-switch", check_stop_switch, true},
    {Check::channels, "channels", check_channels, true},
    {Check::point, "point", check_point, true},
}};

const Named& entry_of(Check check) { return *std::ranges::find(checks, check, &Named::check); }

void require_sense(const SelfTestSettings& settings, const Identity& identity) {
    if (settings.array.elements.size() != identity.channels)
        throw bad_argument("array", fmt::format("it has {} elements and the board {} channels; name the array that the "
                                                "board drives",
                                                settings.array.elements.size(), identity.channels));
    const std::uint32_t last = settings.last_channel.value_or(identity.channels - 1);
    if (last >= identity.channels || settings.first_channel > last)
        throw bad_argument("channels", fmt::format("expected two channels from 0 to {}, the lower one first, not {} "
                                                   "and {}",
                                                   identity.channels - 1, settings.first_channel, last));
    for (const double seconds : {settings.channel_s, settings.point_s})
        if (!(seconds > 0.0 && seconds <= 600.0))
            throw bad_argument("seconds", fmt::format("expected more than 0 and at most 600 s, not {}", seconds));
    const std::string why = settings.array.unreachable(settings.point);
    if (!why.empty()) throw bad_argument("height", why);
}

}  // namespace

std::string_view to_string(Check check) { return entry_of(check).name; }

std::optional<Check> check_named(std::string_view name) {
    const auto* found = std::ranges::find(checks, name, &Named::name);
    return found == checks.end() ? std::nullopt : std::optional(found->check);
}

std::string_view to_string(Outcome outcome) {
    switch (outcome) {
        case Outcome::passed: return "passed";
        case Outcome::failed: return "failed";
        case Outcome::unjudged: break;
    }
    return "unjudged";
}

Image pulsing_image(const Identity& identity, const Array& array, std::span<const std::uint16_t> timings) {
    constexpr double pulsing_hz = 200.0;
    const Timer timer = choose_timer(array, Core{identity.name, identity.core()});
    Image image;
    image.channels = identity.channels;
    image.clock_hz = identity.clock_hz;
    image.timing_bits = identity.timing_bits;
    image.pulse_bits = identity.pulse_bits;
    image.min_pulse_clocks = identity.min_pulse_clocks;
    image.records.push_back({timer.cycle_ticks,
                             timer.prescaler,
                             static_cast<std::uint8_t>(timer.pulse_ticks),
                             {timings.begin(), timings.end()}});
    const auto half = static_cast<std::uint16_t>(std::lround(timer.carrier_hz() / (2.0 * pulsing_hz)));
    image.sequence = {{1, half}, {0, half}};
    return image;
}

namespace {

/// A check in which the board turns its outputs off by itself has failed, and the others are still made.
Finding found_by(const Named& check, Commands& device, const SelfTestSettings& settings) {
    const auto trips = [](const Status& status) { return std::pair(status.watchdog_trips, status.guard_trips); };
    const Status before = device.status();
    try {
        return check.run(device, settings);
    } catch (const LinkLost&) {
        throw;
    } catch (const Error& error) {
        const Status after = device.status();
        if (error.code() != ErrorCode::device || after.enabled || trips(after) == trips(before)) throw;
        return {check.check, Outcome::failed, error.message(),
                "this machine may have been held up, so that the watchdog heard nothing: run this check again"};
    }
}

}  // namespace

std::vector<Finding> self_test(Commands& device, const SelfTestSettings& settings) {
    require_sense(settings, device.identity());
    device.disable();
    device.stop();
    const std::uint16_t watchdog_ms = device.status().watchdog_ms;
    std::vector<Finding> findings;
    for (const Named& check : checks) {
        if (std::ranges::find(settings.checks, check.check) == settings.checks.end()) continue;
        if (check.needs_outputs && device.status().stopped)
            findings.push_back({check.check, Outcome::failed, "the stop input is active, so the outputs stay off",
                                "release the stop switch; without one, see the stop pin in the board's file in "
                                "constraints/"});
        else
            findings.push_back(found_by(check, device, settings));
        if (settings.tell) settings.tell(findings.back());
    }
    device.set_watchdog(watchdog_ms);
    return findings;
}

nlohmann::ordered_json to_json(const std::vector<Finding>& findings) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const Finding& finding : findings) {
        json.push_back(
            {{"check", to_string(finding.check)}, {"outcome", to_string(finding.outcome)}, {"found", finding.found}});
        if (!finding.advice.empty()) json.back()["advice"] = finding.advice;
    }
    return json;
}

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
    constexpr std::uint16_t watchdog_ms = 0;  // silence plays
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

namespace {

/// Asks until the answer begins with one of the letters.
char ask_letter(const SelfTestSettings& settings, const std::string& question, std::string_view letters) {
    while (true) {
        const std::string answer = settings.ask(question);
        if (!answer.empty() && letters.find(answer.front()) != std::string_view::npos) return answer.front();
    }
}

/// A list such as "3 17 20-22". Empty optional: it is none.
std::optional<std::set<std::uint32_t>> channels_in(const std::string& answer, std::uint32_t count) {
    std::set<std::uint32_t> channels;
    const char* at = answer.data();
    const char* const end = at + answer.size();
    const auto number = [&](std::uint32_t& value) {
        const auto [next, error] = std::from_chars(at, end, value);
        at = next;
        return error == std::errc{} && value < count;
    };
    while (at != end) {
        if (*at == ' ' || *at == ',') {
            ++at;
            continue;
        }
        std::uint32_t first = 0, last = 0;
        if (!number(first)) return {};
        last = first;
        if (at != end && *at == '-' && (++at, !number(last) || last < first)) return {};
        for (std::uint32_t channel = first; channel <= last; ++channel) channels.insert(channel);
    }
    return channels;
}

/// The memory that an image of one record and two entries of the sequence takes.
std::vector<Stretch> taken_by_pulsing(const Identity& identity) {
    constexpr std::size_t words_of_sequence = 3;
    return {{interface::primary_base, std::size_t{2} * record_words(identity.channels)},
            {interface::sequence_base, interface::sequence_word_bits / 8 * words_of_sequence}};
}

/// Plays such an image for a while. @return what was wrong, in words; empty when all went well
std::string play_pulsing(Commands& device, const SelfTestSettings& settings, std::span<const std::uint16_t> timings,
                         double for_s, const Progress& progress) {
    upload(device, pulsing_image(device.identity(), settings.array, timings));
    PlaySettings how;
    how.seconds = for_s;
    how.warn = settings.warn;
    try {
        const Played played = play(device, how, [&](const Playing& now) {
            progress(std::min(1.0, now.seconds / for_s));
            return true;
        });
        heed(played.interrupted);
        if (played.guard_trips != 0) return "the guard switched the outputs off";
        if (played.refused_records != 0) return "the board refused to play the record";
    } catch (const LinkLost&) {
        throw;
    } catch (const Error& error) {
        if (error.code() != ErrorCode::device) throw;
        return error.message();
    }
    return {};
}

std::string numbers(const std::set<std::uint32_t>& channels) { return fmt::format("{}", fmt::join(channels, ", ")); }

constexpr std::string_view refused_advice = "run the checks of memories and clock; see `haptogram device status`";

/// What pressing and releasing it does, while the outputs are on.
Finding press_stop_switch(Commands& device, const SelfTestSettings& settings) {
    if (settings.ask("Press the stop switch and hold it, then Enter (n: there is none): ") == "n")
        return {Check::stop_switch, Outcome::unjudged, "there is none",
                "a board that plays to hands wants one: see constraints/README.md"};
    const Status pressed = device.status();
    if (!pressed.stopped || pressed.enabled)
        return {Check::stop_switch, Outcome::failed,
                pressed.stopped ? "seen, but the outputs stay on" : "pressed, but the board does not see it",
                "see its wires, the stop pin in the board's file in constraints/, and stop_level there"};
    settings.ask("Now release it, then Enter: ");
    const Status released = device.status();
    if (released.stopped || released.enabled)
        return {Check::stop_switch, Outcome::failed,
                released.stopped ? "released, but the board still sees it pressed"
                                 : "when it was released, the outputs came on by themselves",
                "see its wires and its pull-up"};
    return {Check::stop_switch, Outcome::passed, "the outputs went off and stayed off"};
}

}  // namespace

Finding check_stop_switch(Commands& device, const SelfTestSettings& settings) {
    if (!settings.ask) return {Check::stop_switch, Outcome::unjudged, "released; nobody was there to press it"};
    constexpr std::uint16_t watchdog_ms = 0;  // a person takes their time, and silence plays
    Finding found;
    heed(while_on(device, watchdog_ms, [&] { found = press_stop_switch(device, settings); }));
    return found;
}

Finding check_channels(Commands& device, const SelfTestSettings& settings) {
    const Identity& identity = device.identity();
    const Progress progress = settings.progress.in_stage(to_string(Check::channels));
    const std::uint32_t first = settings.first_channel, last = settings.last_channel.value_or(identity.channels - 1);
    const KeptMemory kept(device, taken_by_pulsing(identity), settings.warn);
    if (settings.ask)
        settings.ask(
            fmt::format("Channels {} to {} play one after the other, {} s each: hold a microphone or an ear "
                        "near them and note which stay silent. Enter begins: ",
                        first, last, settings.channel_s));
    const std::uint32_t count = last - first + 1;
    for (std::uint32_t channel = first; channel <= last; ++channel) {
        const double at = static_cast<double>(channel - first) / count;
        std::vector<std::uint16_t> timings(identity.channels, interface::silent_timing);
        timings[channel] = 0;
        const std::string wrong =
            play_pulsing(device, settings, timings, settings.channel_s, progress.between(at, at + 1.0 / count));
        if (!wrong.empty())
            return {Check::channels, Outcome::failed, fmt::format("channel {}: {}", channel, wrong),
                    std::string(refused_advice)};
    }
    const std::string played = fmt::format("channels {} to {} played one after the other", first, last);
    if (!settings.ask) return {Check::channels, Outcome::unjudged, played + "; nobody was there to listen"};
    while (true) {
        const std::string answer =
            settings.ask("Which were silent? Numbers such as 3 17 20-22, or Enter when none was: ");
        const auto silent = channels_in(answer, identity.channels);
        if (!silent) continue;
        if (silent->empty()) return {Check::channels, Outcome::passed, played + ", all were heard"};
        return {Check::channels, Outcome::failed,
                silent->size() == count ? "all were silent" : "silent: " + numbers(*silent),
                silent->size() == count
                    ? "see the drivers' supply, and that the driver-enable pin reaches their enable inputs"
                    : "of each, see the transducer's solder joints, its driver's output, and its pin in the board's "
                      "file in constraints/; exchange the transducer with a neighbour to tell which"};
    }
}

Finding check_point(Commands& device, const SelfTestSettings& settings) {
    const Identity& identity = device.identity();
    const Progress progress = settings.progress.in_stage(to_string(Check::point));
    const Timer timer = choose_timer(settings.array, Core{identity.name, identity.core()});
    const std::vector<std::uint16_t> timings = focal_law(settings.array, timer, std::span(&settings.point, 1));
    const KeptMemory kept(device, taken_by_pulsing(identity), settings.warn);
    const std::string place = fmt::format("a point of 200 Hz, {:.0f} mm above the array", 1e3 * settings.point.z);
    if (settings.ask) settings.ask(fmt::format("Hold your palm there. Enter plays {}: ", place));
    while (true) {
        const std::string wrong = play_pulsing(device, settings, timings, settings.point_s, progress);
        if (!wrong.empty()) return {Check::point, Outcome::failed, wrong, std::string(refused_advice)};
        if (!settings.ask) return {Check::point, Outcome::unjudged, place + " was played; nobody was there to feel it"};
        const char felt = ask_letter(settings, "You should feel this. Did you? (y, n, or a to play it again): ", "yna");
        if (felt == 'y') return {Check::point, Outcome::passed, place + " was felt"};
        if (felt == 'n') break;
    }
    return {Check::point, Outcome::failed, place + " was not felt",
            "when single channels are heard and the point is not felt, their phases are wrong: see that the array "
            "file's places, pitch and numbering are those of the board (a mirrored cable mirrors the array), that all "
            "transducers have the same polarity, and the drivers' supply: a tenth of the pressure feels like nothing"};
}

}  // namespace haptogram::link
