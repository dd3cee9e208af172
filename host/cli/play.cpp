// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/image/image.hpp"
#include "haptogram/link/transfer.hpp"
#include "interrupt.hpp"
#include "live.hpp"
#include "outputs.hpp"
#include "port.hpp"
#include "progress_line.hpp"

namespace haptogram::cli {
namespace {

struct PlayOptions {
    PortOptions port;
    bool sequence = false;  ///< says what is so anyway
    std::uint16_t index = 0;
    std::optional<std::uint16_t> loops;  ///< else as the image says
    double rate_hz = 0.0;                ///< else as its dwells say
    double seconds = 0.0;
    std::uint16_t watchdog_ms = 500;
    bool json = false;
};

/// The board's sequence with its dwells stretched so that a pass lasts 1 / rate.
std::vector<SequenceEntry> at_rate(std::vector<SequenceEntry> sequence, double rate_hz, double carrier_hz) {
    double total = 0.0;
    for (const SequenceEntry& entry : sequence) total += entry.dwell;
    const double cycles = carrier_hz / rate_hz;
    double before = 0.0;
    for (SequenceEntry& entry : sequence) {
        const double after = before + entry.dwell;
        const double dwell = std::round(cycles * after / total) - std::round(cycles * before / total);
        if (dwell < 1.0 || dwell > 65535.0)
            throw Error(ErrorCode::bad_argument, "--rate",
                        fmt::format("at {} passes a second an entry of the sequence would last {} carrier cycles, "
                                    "expected 1 to 65535; about {:.3g} a second is most here",
                                    rate_hz, dwell, carrier_hz / static_cast<double>(sequence.size())));
        entry.dwell = static_cast<std::uint16_t>(dwell);
        before = after;
    }
    return sequence;
}

/// Plays the sequence at another rate than it was compiled for: its indices go through the live FIFO, and the board's
/// memory stays as it is.
int play_at_rate(const PlayOptions& options) {
    Device device(options.port);
    const Image image = link::download(device.client(), device.identity(), 0, options.port.port);
    const auto carried = std::ranges::find_if(image.sequence, [](const SequenceEntry& e) { return e.index != 0; });
    if (carried == image.sequence.end())
        throw Error(ErrorCode::device, options.port.port, "the sequence in its memory plays no record");
    const double carrier_hz = record_carrier_hz(device, carried->index);
    const std::vector<SequenceEntry> pass = at_rate(image.sequence, options.rate_hz, carrier_hz);
    const std::uint64_t passes = options.loops.value_or(image.loops);
    std::uint64_t entries = passes * pass.size();  // 0: for ever
    if (options.seconds > 0.0) {
        const auto most = static_cast<std::uint64_t>(
            std::max(1.0, std::round(options.seconds * options.rate_hz * static_cast<double>(pass.size()))));
        entries = entries == 0 ? most : std::min(entries, most);
    }
    std::uint64_t told = 0;
    const Fed fed = feed(
        device, options.watchdog_ms,
        [&](int) -> std::optional<SequenceEntry> {
            if (entries != 0 && told == entries) return {};
            return pass[told++ % pass.size()];
        },
        [&] { return entries != 0 && told == entries; });
    tell(fed, options.json);
    return 0;
}

int play(const PlayOptions& options) {
    catch_interrupts();
    if (options.rate_hz > 0.0) return play_at_rate(options);
    Device device(options.port);
    link::Client& client = device.client();
    client.set_watchdog(options.watchdog_ms);
    const link::BoardStatus before = client.status();
    link::BoardStatus now = before;
    const auto since = [](std::uint16_t from, std::uint16_t to) { return static_cast<std::uint16_t>(to - from); };
    std::uint16_t length = 0;
    if (options.index == 0) {
        const link::Bytes header = client.read(interface::sequence_base, 4);
        length = static_cast<std::uint16_t>((header.at(0) | header.at(1) << 8) & 0x7fff);
        if (length == 0)
            throw Error(ErrorCode::device, options.port.port,
                        "there is no sequence in the board's memory; upload an image first");
    }
    {
        const Outputs on(client);
        if (options.index != 0)
            client.select(options.index);
        else
            client.start(1, options.loops ? length : std::uint16_t{0}, options.loops.value_or(0));
        const auto begun = std::chrono::steady_clock::now();
        const auto elapsed = [begun] {
            return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
        };
        // Asking for the status is what tells the watchdog that this host is alive.
        const std::chrono::milliseconds pause = keep_alive_pause(options.watchdog_ms);
        ProgressLine progress("play");
        do {
            std::this_thread::sleep_for(pause);
            now = client.status();
            progress.note(fmt::format("{:.1f} s, record {}, {} underruns", elapsed(), now.present_index,
                                      since(before.underruns, now.underruns)));
            require_on(now);
        } while (!interrupted() && (now.mode != 0 || now.present_index != 0) &&
                 (options.seconds == 0.0 || elapsed() < options.seconds));
    }
    const nlohmann::ordered_json json = {{"underruns", since(before.underruns, now.underruns)},
                                         {"refused_records", since(before.refused_records, now.refused_records)},
                                         {"watchdog_trips", since(before.watchdog_trips, now.watchdog_trips)},
                                         {"guard_trips", since(before.guard_trips, now.guard_trips)},
                                         {"interrupted", interrupted()}};
    if (options.json)
        fmt::print("{}\n", json.dump(1));
    else
        fmt::print("{} underruns, {} refused records\n", json["underruns"].dump(), json["refused_records"].dump());
    return 0;
}

}  // namespace

void add_play(CLI::App& app, Action& action) {
    auto options = std::make_shared<PlayOptions>();
    CLI::App* sub = app.add_subcommand(
        "play",
        "Turn the outputs on and play what is in the board's memories, until its end or Ctrl-C; then off again");
    add_port_options(*sub, options->port);
    auto* index = sub->add_option("--index", options->index, "One record, until Ctrl-C")->check(whole(1, 65535));
    sub->add_option("--loops", options->loops, "Passes over the sequence; 0: until Ctrl-C (default: as the image says)")
        ->check(whole(0, 65535))
        ->excludes(index);
    sub->add_flag("--sequence", options->sequence, "The whole sequence, which is what is played without --index")
        ->excludes(index);
    sub->add_option("--rate", options->rate_hz,
                    "Passes a second, instead of as it was compiled; the indices go over the link then")
        ->check(positive())
        ->excludes(index);
    sub->add_option("--seconds", options->seconds, "Not longer than this")->check(positive());
    add_watchdog_option(*sub, options->watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return play(*options); }; });
}

}  // namespace haptogram::cli
