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
#include "haptogram/link/serial_line.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/transfer.hpp"
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
    std::optional<std::uint16_t> first, loops;
    std::uint16_t length = 0;
    std::uint64_t at_period = 0;
    std::uint32_t in_periods = 0;
    bool after = false, on_trigger = false;
    bool once = false, off = false;
    std::string role;
    bool json = false;
};

int info(const DeviceOptions& options) {
    const link::Device device(options.port);
    nlohmann::ordered_json told = to_json(device.identity());
    if (const auto waits_ms = link::latency_ms(options.port.port)) told["latency_timer_ms"] = *waits_ms;
    tell(told, options.json);
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

/// Whatever state the board and the line are in: no session comes before it.
int disable(const DeviceOptions& options) {
    link::Client device(link::open_port_to_turn_off(options.port));
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
    const std::uint16_t first = options.first.value_or(1);
    std::uint16_t length = options.length;
    if (length == 0 && (options.first || options.loops)) {
        // A START without a length takes the loops of the memory, too, so the rest of the sequence is named.
        const std::uint16_t all = link::sequence_length(device);
        if (first > all)
            throw bad_argument("first",
                               fmt::format("{}: the sequence in the board's memory has {} entries", first, all));
        length = static_cast<std::uint16_t>(all - first + 1);
    }
    device.start(first, length, options.loops.value_or(0), when(device, options));
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

}  // namespace

void add_device(CLI::App& app, Action& action) {
    CLI::App* sub = app.add_subcommand("device", "Ask a board what it is and does, and control its outputs");
    sub->callback([sub, &action] {
        if (sub->get_subcommands().empty())
            action = []() -> int {
                throw Error(ErrorCode::bad_argument, "device",
                            "expected a subcommand: list, info, status, enable, disable, stop, start, modulate, sync, "
                            "trigger or self-test; see haptogram device --help");
            };
    });
    add_device_list(*sub, action);
    auto options = std::make_shared<DeviceOptions>();
    const auto add = [&](const char* name, const char* about, int (*what)(const DeviceOptions&)) {
        CLI::App* command = sub->add_subcommand(name, about);
        add_port_options(*command, options->port);
        command->add_flag("--json", options->json, "As JSON; of a command that changes something, the status after it");
        command->callback([options, &action, what] { action = [options, what] { return what(*options); }; });
        return command;
    };
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
    bank->add_option("--first", options->first, "Its first entry (default: 1)")->check(whole(1, 32767));
    bank->add_option("--length", options->length, "So many entries; 0: to the sequence's end")
        ->check(whole(0, 32767))
        ->capture_default_str();
    bank->add_option("--loops", options->loops,
                     "So often; 0: for ever (default: as the memory says for the whole sequence, and 0 for a part)")
        ->check(whole(0, 65535));
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
    add("sync", "Reset the board, and then keep its carrier cycles in step with other boards over the wire SYNC", sync)
        ->add_option("role", options->role, "alone, master or slave")
        ->required()
        ->check(CLI::IsMember(role_names()));
    add_device_trigger(*sub, action);
    add_self_test(*sub, action);
}

}  // namespace haptogram::cli
