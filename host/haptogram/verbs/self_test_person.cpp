// SPDX-License-Identifier: Apache-2.0
// The checks that a person judges: the stop switch, which transducers are silent, and whether a point is felt.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cstddef>
#include <set>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/link/kept_memory.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/solve/focal_law.hpp"
#include "haptogram/verbs/self_test_checks.hpp"

namespace haptogram::link {
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
