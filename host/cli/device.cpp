// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device.hpp"

#include <fmt/format.h>

#include <memory>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/to_json.hpp"
#include "port.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct DeviceOptions {
    link::PortSettings port;
    std::uint16_t watchdog_ms = 0;
    bool has_watchdog = false;
    std::uint16_t divider = 1, samples = 0;
    bool once = false, off = false;
    bool json = false;
};

int info(const DeviceOptions& options) {
    const link::Device device(options.port);
    tell(to_json(device.identity()), options.json);
    return 0;
}

int status(const DeviceOptions& options) {
    link::Device device(options.port);
    tell(to_json(device.status()), options.json);
    return 0;
}

/// A command that changes something prints nothing; with --json it prints the status after the change.
int after_change(link::Device& device, const DeviceOptions& options) {
    if (options.json) tell(to_json(device.status()), true);
    return 0;
}

int enable(const DeviceOptions& options) {
    link::Device device(options.port);
    if (options.has_watchdog) device.set_watchdog(options.watchdog_ms);
    device.enable();
    return after_change(device, options);
}

int disable(const DeviceOptions& options) {
    link::Device device(options.port);
    device.disable();
    return after_change(device, options);
}

int stop(const DeviceOptions& options) {
    link::Device device(options.port);
    device.stop();
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
        device.modulate(0, 0, false);
    else
        device.modulate(options.divider, options.samples, !options.once);
    return after_change(device, options);
}

int list(bool as_json) {
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
                throw Error(ErrorCode::bad_argument, "device",
                            "expected a subcommand: list, info, status, enable, disable, stop or modulate; see "
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
    CLI::App* ports = sub->add_subcommand("list", "Print the serial ports and the FTDI chips");
    ports->add_flag("--json", options->json, "As JSON");
    ports->callback([options, &action] { action = [options] { return list(options->json); }; });

    add("info", "Print what the board is", info);
    add("status", "Print what it is doing, and its counters", status);
    auto* watchdog =
        add("enable", "Turn the outputs on; they go off again when no host speaks within the watchdog's time", enable)
            ->add_option("--watchdog", options->watchdog_ms,
                         "That time in ms; 0 leaves them on with no host (default: as it is, 500 after reset)")
            ->check(whole(0, 65535));
    watchdog->each([options](const std::string&) { options->has_watchdog = true; });
    add("disable", "Turn the outputs off, at once", disable);
    add("stop", "Silence after the present cycle; outputs stay as they are", stop);
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
    auto* once = modulation->add_flag("--once", options->once, "Not over and over; the last sample stays");
    modulation->add_flag("--off", options->off, "End the modulation")->excludes(once);
}

}  // namespace haptogram::cli
