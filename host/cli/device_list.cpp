// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/to_json.hpp"
#include "haptogram/link/udp_port.hpp"
#include "port.hpp"
#include "report.hpp"

namespace haptogram::cli {
namespace {

struct ListOptions {
    std::vector<std::string> ports, at;
    std::optional<std::uint32_t> baud;
    bool net = false, json = false;
};

/// Who answers behind each port that was named, instead of which ports there are.
int list_chains(const ListOptions& options) {
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    for (const std::string& port : options.ports) {
        const link::PortSettings settings{.port = port, .baud = options.baud, .found = tell_rate};
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
int list_networks(const ListOptions& options) {
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

int list(const ListOptions& options) {
    if (options.net) return list_networks(options);
    if (!options.ports.empty()) return list_chains(options);
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

void add_device_list(CLI::App& device, Action& action) {
    auto options = std::make_shared<ListOptions>();
    CLI::App* ports =
        device.add_subcommand("list", "Print the serial ports and the FTDI chips, or who answers behind one");
    ports
        ->add_option("--port", options->ports,
                     "Ask behind this port: each tile of a chain, or the one board there; again for each port")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    add_baud_option(*ports, options->baud);
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
}

}  // namespace haptogram::cli
