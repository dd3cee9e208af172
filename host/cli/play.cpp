// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "base/error.hpp"
#include "command.hpp"
#include "interrupt.hpp"
#include "outputs.hpp"
#include "port.hpp"

namespace haptogram::cli {
namespace {

struct PlayOptions {
    PortOptions port;
    std::uint16_t index = 0;
    std::optional<std::uint16_t> loops;  ///< else as the image says
    double seconds = 0.0;
    std::uint16_t watchdog_ms = 500;
    bool json = false;
};

int play(const PlayOptions& options) {
    catch_interrupts();
    Device device(options.port);
    link::Client& client = device.client();
    client.set_watchdog(options.watchdog_ms);
    const link::BoardStatus before = client.status();
    link::BoardStatus now = before;
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
        do {
            std::this_thread::sleep_for(pause);
            now = client.status();
            if (!now.enabled)
                throw Error(ErrorCode::device, options.port.port,
                            "the board has turned its outputs off: its watchdog or guard tripped");
        } while (!interrupted() && (now.mode != 0 || now.present_index != 0) &&
                 (options.seconds == 0.0 || elapsed() < options.seconds));
    }
    const auto since = [](std::uint16_t from, std::uint16_t to) { return static_cast<std::uint16_t>(to - from); };
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
    sub->add_option("--seconds", options->seconds, "Not longer than this")->check(positive());
    add_watchdog_option(*sub, options->watchdog_ms);
    sub->add_flag("--json", options->json, "Print the outcome as JSON");
    sub->callback([options, &action] { action = [options] { return play(*options); }; });
}

}  // namespace haptogram::cli
