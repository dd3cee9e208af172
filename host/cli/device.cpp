// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <vector>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/ftdi_port.hpp"
#include "port.hpp"

namespace haptogram::cli {
namespace {

using nlohmann::ordered_json;

struct DeviceOptions {
    PortOptions port;
    std::uint16_t watchdog_ms = 0;
    bool has_watchdog = false;
    bool json = false;
};

/// As "name  value" lines, or as JSON.
void print(const ordered_json& values, bool as_json) {
    if (as_json) {
        fmt::print("{}\n", values.dump(1));
        return;
    }
    for (const auto& [name, value] : values.items())
        fmt::print("{:16} {}\n", name, value.is_string() ? value.get<std::string>() : value.dump());
}

int info(const DeviceOptions& options) {
    Device device(options.port);
    const link::Identity& i = device.identity();
    print({{"name", i.name},
           {"version", fmt::format("{}.{}", i.version_major, i.version_minor)},
           {"channels", i.channels},
           {"records", i.records},
           {"sequence_depth", i.sequence_depth},
           {"live_depth", i.live_depth},
           {"timing_bits", i.timing_bits},
           {"pulse_bits", i.pulse_bits},
           {"clock_hz", i.clock_hz},
           {"frame_bytes", i.frame_bytes}},
          options.json);
    return 0;
}

void tell_status(Device& device, bool as_json) {
    const link::BoardStatus s = device.client().status();
    constexpr std::string_view modes[] = {"idle", "single", "sequence", "live"};
    print({{"outputs", s.enabled ? "on" : "off"},
           {"mode", modes[s.mode & 3U]},
           {"index", s.present_index},
           {"live_level", s.live_level},
           {"watchdog_ms", s.watchdog_ms},
           {"underruns", s.underruns},
           {"refused_records", s.refused_records},
           {"frames_good", s.frames_good},
           {"frames_damaged", s.frames_damaged},
           {"frames_repeated", s.frames_repeated},
           {"frames_refused", s.frames_refused},
           {"watchdog_trips", s.watchdog_trips},
           {"guard_trips", s.guard_trips}},
          as_json);
}

int status(const DeviceOptions& options) {
    Device device(options.port);
    tell_status(device, options.json);
    return 0;
}

/// A command that changes something says what is so after it when a program asks.
int then_tell(Device& device, const DeviceOptions& options) {
    if (options.json) tell_status(device, true);
    return 0;
}

int enable(const DeviceOptions& options) {
    Device device(options.port);
    if (options.has_watchdog) device.client().set_watchdog(options.watchdog_ms);
    device.client().enable();
    return then_tell(device, options);
}

int disable(const DeviceOptions& options) {
    Device device(options.port);
    device.client().disable();
    return then_tell(device, options);
}

int stop(const DeviceOptions& options) {
    Device device(options.port);
    device.client().stop();
    return then_tell(device, options);
}

/// Serial ports by the names that do not change with the order of plugging, then those without one, and FTDI chips.
int list(bool as_json) {
    ordered_json ports = ordered_json::array();
    std::vector<std::filesystem::path> named;
    std::error_code error;  // a folder that is not there has no ports
    const auto add = [&](const std::filesystem::path& path, const std::string& name) {
        ports.push_back({{"port", path.string()}, {"name", name}});
    };
    for (const auto& entry : std::filesystem::directory_iterator("/dev/serial/by-id", error)) {
        const std::filesystem::path target = std::filesystem::canonical(entry.path(), error);
        named.push_back(target);
        add(target, entry.path().filename().string());
    }
    for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
        const std::string name = entry.path().filename().string();
        if ((name.starts_with("ttyUSB") || name.starts_with("ttyACM")) &&
            std::find(named.begin(), named.end(), entry.path()) == named.end())
            add(entry.path(), "");
    }
    for (const link::FtdiDevice& device : link::ftdi_devices()) add(device.name, device.product);
    std::sort(ports.begin(), ports.end());
    if (as_json)
        fmt::print("{}\n", ports.dump(1));
    else
        for (const auto& port : ports)
            fmt::print("{} {}\n", port["port"].get<std::string>(), port["name"].get<std::string>());
    return 0;
}

}  // namespace

void add_device(CLI::App& app, Action& action) {
    CLI::App* sub = app.add_subcommand("device", "A board behind a serial port: what it is and does, and its outputs");
    sub->callback([sub, &action] {
        if (sub->get_subcommands().empty())
            action = []() -> int {
                throw Error(ErrorCode::bad_argument, "device",
                            "expected a subcommand: list, info, status, enable, disable or stop; see haptogram device "
                            "--help");
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
}

}  // namespace haptogram::cli
