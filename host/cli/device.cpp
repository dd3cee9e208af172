// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device.hpp"

#include <fmt/format.h>

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/link/trigger.hpp"
#include "haptogram/link/udp_port.hpp"
#include "interrupt.hpp"
#include "port.hpp"
#include "report.hpp"
#include "rig_ports.hpp"

namespace haptogram::cli {
namespace {

struct DeviceOptions {
    link::PortSettings port;
    RigPorts ports;  ///< of status
    std::uint16_t watchdog_ms = 0;
    bool has_watchdog = false;
    std::uint16_t divider = 1, samples = 0;
    std::uint32_t first_sample = 0;
    std::uint16_t first = 1, length = 0, loops = 0;
    std::uint64_t at_period = 0;
    std::uint32_t in_periods = 0;
    bool after = false, on_trigger = false;
    std::string event, input, test;
    double pulse_ms = -1, settle_ms = -1;
    std::uint16_t every = 0;
    std::uint32_t channel = 0;
    bool level = false, gate = false;
    bool once = false, off = false;
    std::string role;
    bool net = false;
    std::vector<std::string> at;
    bool json = false;
};

int info(const DeviceOptions& options) {
    const link::Device device(options.port);
    tell(to_json(device.identity()), options.json);
    return 0;
}

/// What each tile of a rig is doing, and whether it holds its own image.
int rig_status(const DeviceOptions& options) {
    const RigBundle bundle = load_rig_bundle(options.ports.rig);
    const std::vector<link::PortSettings> ports = options.ports.of(bundle);
    const link::RigDevices devices(bundle, ports);
    nlohmann::ordered_json states = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < ports.size(); ++i) {
        const link::Tile& tile = devices.tiles()[i];
        nlohmann::ordered_json state{{"tile", i + 1}, {"port", ports[i].port}};
        state.update(to_json(tile.device.status()));
        state["holds_its_image"] = link::holds(tile.device, tile.image);
        states.push_back(std::move(state));
    }
    if (options.json) tell(states, true);
    for (std::size_t i = 0; !options.json && i < states.size(); ++i) {
        if (i > 0) fmt::print("\n");
        tell(states[i], false);
    }
    return 0;
}

int status(const DeviceOptions& options) {
    if (options.ports.is_rig()) return rig_status(options);
    link::Device device(options.ports.one());
    tell(to_json(device.status()), options.json);
    return 0;
}

/// A command that changes something prints nothing; with --json it prints the status after the change.
int after_change(link::Client& device, const DeviceOptions& options) {
    if (options.json) tell(to_json(device.status()), true);
    return 0;
}

/// Outputs are on behind it only if it succeeds.
int enable(const DeviceOptions& options) {
    catch_interrupts();
    link::PortSettings port = options.port;
    port.interrupt = interrupts;
    link::Device device(port);
    if (options.has_watchdog) device.set_watchdog(options.watchdog_ms);
    bool enabled = false;
    const auto on = [&] {
        device.enable();
        enabled = true;
    };
    const auto off = [&] {
        if (enabled || device.turn_off()) return std::string();
        return link::not_confirmed(options.has_watchdog ? std::optional(options.watchdog_ms) : std::nullopt);
    };
    if (link::then_off(on, off)) throw link::Interrupted();
    return after_change(device, options);
}

/// The line to a board that is to be turned off: where its rate is not known, the question turns it off already. To one
/// that answers at none, a break is left, which is one at any rate.
std::unique_ptr<link::Transport> line_to_turn_off(const link::PortSettings& port) {
    try {
        return link::open_port(port, interface::Command::disable);
    } catch (const link::LinkLost&) {
        return link::open_port(port.port, port.baud.value_or(link::known_rates.back()));
    }
}

/// Whatever state the board and the line are in: no session comes before it.
int disable(const DeviceOptions& options) {
    link::Client device(line_to_turn_off(options.port));
    if (!device.turn_off()) throw Error(ErrorCode::device, options.port.port, link::not_confirmed({}));
    if (options.json) device.identify();
    return after_change(device, options);
}

int stop(const DeviceOptions& options) {
    link::Device device(options.port);
    device.stop();
    return after_change(device, options);
}

link::When when(link::Device& device, const DeviceOptions& options) {
    if (options.after) return link::When::at_end();
    if (options.on_trigger) return link::When::at_trigger();
    if (options.at_period != 0) return link::When::at_period(options.at_period);
    if (options.in_periods == 0) return link::When::at_once();
    const std::optional<std::uint64_t> period = device.status().period;
    if (!period) throw Error(ErrorCode::device, options.port.port, "this board counts no carrier periods");
    return link::When::at_period(*period + options.in_periods);
}

int start(const DeviceOptions& options) {
    link::Device device(options.port);
    device.start(options.first, options.length, options.loops, when(device, options));
    return after_change(device, options);
}

int modulate(const DeviceOptions& options) {
    link::Device device(options.port);
    const std::uint32_t most = 2 * device.identity().modulation_words;
    if (most == 0) throw Error(ErrorCode::device, options.port.port, "this board has no modulation");
    if (options.samples > most)
        throw Error(ErrorCode::bad_argument, "--samples",
                    fmt::format("the board holds {} samples, not {}", most, options.samples));
    if (options.off)
        device.modulate(0, 0, false, 0, when(device, options));
    else
        device.modulate(options.divider, options.samples, !options.once, options.first_sample, when(device, options));
    return after_change(device, options);
}

/// The value of this name; the options' checks let no other pass.
template <class Value>
Value named(const std::string& name, unsigned last) {
    unsigned value = 0;
    while (value < last && to_string(static_cast<Value>(value)) != name) ++value;
    return static_cast<Value>(value);
}

template <class Value>
std::vector<std::string> names_up_to(Value last) {
    std::vector<std::string> names;
    for (unsigned value = 0; value <= static_cast<unsigned>(last); ++value)
        names.emplace_back(to_string(static_cast<Value>(value)));
    return names;
}

/// What was said changes, the rest stays. Prints all of it, and what the board has seen.
int trigger(const DeviceOptions& options) {
    link::Device device(options.port);
    const link::TriggerSettings before = trigger_settings(device);
    link::TriggerSettings settings = before;
    if (!options.event.empty())
        settings.event = named<link::Event>(options.event, static_cast<unsigned>(link::Event::samples));
    if (options.every != 0) settings.every_periods = options.every;
    if (options.pulse_ms >= 0) settings.pulse_s = 1e-3 * options.pulse_ms;
    if (!options.input.empty()) {
        settings.active_low = options.input == "low";
        settings.by_level = options.level;
        settings.gates = options.gate;
    }
    if (options.settle_ms >= 0) settings.settle_s = 1e-3 * options.settle_ms;
    if (!options.test.empty()) {
        settings.test = named<link::Test>(options.test, static_cast<unsigned>(link::Test::index));
        settings.channel = options.channel;
    }
    if (options.every != 0 && settings.event != link::Event::period)
        throw bad_argument("every", fmt::format("is of --out period; the event is {}", to_string(settings.event)));
    if (options.channel != 0 && settings.test != link::Test::carrier)
        throw bad_argument("channel",
                           fmt::format("is of --test carrier; the test output is {}", to_string(settings.test)));
    if (settings != before) set_trigger(device, settings);
    nlohmann::ordered_json told = to_json(trigger_settings(device));
    told.update(to_json(trigger_times(device), device.identity().clock_hz));
    tell(told, options.json);
    return 0;
}

constexpr std::array roles = {link::Role::alone, link::Role::master, link::Role::slave};

std::vector<std::string> role_names() {
    std::vector<std::string> names;
    names.reserve(roles.size());
    for (const link::Role role : roles) names.emplace_back(to_string(role));
    return names;
}

int sync(const DeviceOptions& options) {
    link::Device device(options.port);
    if (device.identity().core().sync == 0) throw Error(ErrorCode::device, options.port.port, "this board has no SYNC");
    for (const link::Role role : roles)
        if (to_string(role) == options.role) device.set_role(role);
    return after_change(device, options);
}

/// Who answers behind each port that was named, instead of which ports there are.
int list_chains(const DeviceOptions& options) {
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    for (const std::string& port : options.ports.ports) {
        const link::PortSettings settings{.port = port, .baud = options.ports.baud, .found = tell_rate};
        for (const link::FoundDevice& device : link::devices_behind(settings)) {
            const link::Identity& identity = device.identity;
            if (!options.json)
                fmt::print("{} {} channels, {} records, {} MHz\n", device.port, identity.channels, identity.records,
                           identity.clock_hz / 1e6);
            nlohmann::ordered_json row{{"port", device.port}};
            row.update(to_json(identity));
            found.push_back(std::move(row));
        }
    }
    if (options.json) tell(found, true);
    return 0;
}

/// Who answers a question to all.
int list_networks(const DeviceOptions& options) {
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    constexpr std::chrono::milliseconds patience{300};
    std::vector<link::AboutBoard> boards = link::boards_of_networks(patience);
    for (const std::string& port : options.at)
        if (const auto board = link::UdpPort(port).ask(patience)) boards.push_back(*board);
    for (const link::AboutBoard& board : boards) {
        const link::Identity& identity = board.identity;
        if (!options.json)
            fmt::print("{} {} channels, {} records, {} MHz, {}, outputs {}\n", board.port, identity.channels,
                       identity.records, identity.clock_hz / 1e6, board.held ? "held by a peer" : "free",
                       board.enabled ? "on" : "off");
        nlohmann::ordered_json row{{"port", board.port},
                                   {"held", board.held},
                                   {"enabled", board.enabled},
                                   {"datagrams_taken", board.accepted},
                                   {"datagrams_refused", board.refused},
                                   {"datagrams_damaged", board.damaged}};
        row.update(to_json(identity));
        found.push_back(std::move(row));
    }
    if (options.json) tell(found, true);
    return 0;
}

int list(const DeviceOptions& options) {
    if (options.net) return list_networks(options);
    if (!options.ports.ports.empty()) return list_chains(options);
    const bool as_json = options.json;
    const std::vector<link::PortInfo> ports = link::available_ports();
    if (as_json) {
        tell(link::to_json(ports), true);
        return 0;
    }
    for (const link::PortInfo& port : ports) fmt::print("{} {}\n", port.port, port.name);
    return 0;
}

}  // namespace

void add_device(CLI::App& app, Action& action) {
    CLI::App* sub = app.add_subcommand("device", "A board behind a serial port: what it is and does, and its outputs");
    sub->callback([sub, &action] {
        if (sub->get_subcommands().empty())
            action = []() -> int {
                throw Error(
                    ErrorCode::bad_argument, "device",
                    "expected a subcommand: list, info, status, enable, disable, stop, start, modulate, trigger, "
                    "sync or "
                    "self-test; see "
                    "haptogram device --help");
            };
    });
    auto options = std::make_shared<DeviceOptions>();
    const auto add = [&](const char* name, const char* about, int (*what)(const DeviceOptions&)) {
        CLI::App* command = sub->add_subcommand(name, about);
        add_port_options(*command, options->port);
        command->add_flag("--json", options->json, "As JSON; of a command that changes something, the status after it");
        command->callback([options, &action, what] { action = [options, what] { return what(*options); }; });
        return command;
    };
    CLI::App* ports =
        sub->add_subcommand("list", "Print the serial ports and the FTDI chips, or who answers behind one");
    ports
        ->add_option("--port", options->ports.ports,
                     "Ask behind this port: each tile of a chain, or the one board there; again for each port")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    add_baud_option(*ports, options->ports.baud);
    auto* net = ports
                    ->add_flag("--net", options->net,
                               "Ask all networks of this machine, and virtual boards on it, which boards there are")
                    ->excludes(ports->get_option("--port"));
    ports
        ->add_option("--at", options->at,
                     "Ask udp:ADDRESS[:PORT], too, where no question to all arrives; again for each")
        ->needs(net)
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    ports->add_flag("--json", options->json, "As JSON");
    ports->callback([options, &action] { action = [options] { return list(*options); }; });

    add("info", "Print what the board is", info);
    CLI::App* now = sub->add_subcommand("status", "Print what it is doing, and its counters; or each board of a rig");
    add_rig_port_options(*now, options->ports);
    now->add_flag("--json", options->json, "As JSON");
    now->callback([options, &action] { action = [options] { return status(*options); }; });
    auto* watchdog =
        add("enable", "Turn the outputs on; they go off again when no host speaks within the watchdog's time", enable)
            ->add_option("--watchdog", options->watchdog_ms,
                         "That time in ms; 0 leaves them on with no host (default: as it is, 500 after reset)")
            ->check(whole(0, 65535));
    watchdog->each([options](const std::string&) { options->has_watchdog = true; });
    add("disable", "Turn the outputs off, at once, and end what plays; whatever the board does and the line has lost",
        disable);
    add("stop", "Silence after the present cycle; outputs stay as they are", stop);
    const auto add_when = [options](CLI::App& command) {
        auto* after = command.add_flag("--after", options->after,
                                       "When what plays now has ended: for ever is until the end of its present pass");
        auto* trigger =
            command
                .add_flag("--on-trigger", options->on_trigger,
                          "When the trigger input says so (device trigger); whatever turns outputs off ends the wait")
                ->excludes(after);
        auto* at = command
                       .add_option("--at-period", options->at_period,
                                   "Not before this carrier period, counted from the board's reset; device status "
                                   "tells the present one")
                       ->check(CLI::Range(std::uint64_t{1}, link::When::at_trigger().gate - 1))
                       ->excludes(after)
                       ->excludes(trigger);
        command
            .add_option("--in-periods", options->in_periods,
                        "Not before so many carrier periods from now, which the way to the board takes a part of")
            ->check(whole(1, 4'000'000'000))
            ->excludes(after)
            ->excludes(trigger)
            ->excludes(at);
    };
    CLI::App* bank = add("start",
                         "Play a part of the sequence in the board's memory, a bank; outputs stay as they are, and a "
                         "watchdog of 0 (device enable --watchdog 0) lets it play with no host",
                         start);
    bank->add_option("--first", options->first, "Its first entry")->check(whole(1, 32767))->capture_default_str();
    bank->add_option("--length", options->length, "So many entries; 0: the whole sequence, with its loops")
        ->check(whole(0, 32767))
        ->capture_default_str();
    bank->add_option("--loops", options->loops, "So often; 0: for ever")->check(whole(0, 65535))->capture_default_str();
    add_when(*bank);
    CLI::App* modulation = add("modulate",
                               "Multiply all amplitudes by the samples in the board's modulation memory, from the "
                               "first on, whatever plays; an upload does so as its image says",
                               modulate);
    modulation->add_option("--divider", options->divider, "Carrier periods that a sample lasts")
        ->check(whole(1, 65535))
        ->capture_default_str();
    modulation->add_option("--samples", options->samples, "So many samples; 0: all that the board holds")
        ->check(whole(0, 65535))
        ->capture_default_str();
    modulation
        ->add_option("--first", options->first_sample,
                     "Number of the first sample, even; another than 0 takes a board with schedule")
        ->check(whole(0, 65534))
        ->capture_default_str();
    add_when(*modulation);
    auto* once = modulation->add_flag("--once", options->once, "Not over and over; the last sample stays");
    modulation->add_flag("--off", options->off, "End the modulation")->excludes(once);
    CLI::App* pins = add("trigger",
                         "Set up the trigger pins and the test output of a board that has them, and print how they "
                         "are and when they changed last; what is not said stays as it is",
                         trigger);
    pins->add_option("--out", options->event,
                     "What makes a pulse at the trigger output: start of playing, mark of an entry, pass of a "
                     "sequence, period of the carrier, or samples of the modulation from the first one")
        ->check(CLI::IsMember(names_up_to(link::Event::samples)));
    pins->add_option("--every", options->every, "Of period: carrier periods from one pulse to the next")
        ->check(whole(1, 65535));
    pins->add_option("--pulse", options->pulse_ms, "How long the output is high, in ms")->check(CLI::Range(0.0, 1e4));
    auto* input =
        pins->add_option(
                "--in", options->input,
                "The level at which the trigger input is active; without --level and --gate, these are off then")
            ->check(CLI::IsMember(std::vector<std::string>{"high", "low"}));
    pins->add_flag("--level", options->level,
                   "What waits for the trigger begins while the input is active, not only when it becomes so")
        ->needs(input);
    pins->add_flag("--gate", options->gate, "No pulse reaches the transducers while the input is not active")
        ->needs(input);
    pins->add_option("--settle", options->settle_ms,
                     "For which a change of the input must last before it counts, in ms")
        ->check(CLI::Range(0.0, 1e3));
    auto* test = pins->add_option("--test", options->test,
                                  "What an oscilloscope sees at the test output: the carrier of a channel, a change at "
                                  "each cycle, or with each new index")
                     ->check(CLI::IsMember(names_up_to(link::Test::index)));
    pins->add_option("--channel", options->channel, "Of carrier")
        ->check(whole(0, 999))
        ->capture_default_str()
        ->needs(test);
    add("sync", "Reset the board, and then keep its carrier cycles in step with other boards over the wire SYNC", sync)
        ->add_option("role", options->role, "alone, master or slave")
        ->required()
        ->check(CLI::IsMember(role_names()));
    add_self_test(*sub, action);
}

}  // namespace haptogram::cli
