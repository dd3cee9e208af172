// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device.hpp"

#include <fmt/format.h>

#include "haptogram/format/interface.hpp"
#include "haptogram/link/chain.hpp"
#include "haptogram/link/port_rates.hpp"
#include "haptogram/link/udp_port.hpp"

namespace haptogram::link {

namespace {

/// A rate at which something answers behind a port that is not open.
std::optional<std::uint32_t> rate_of(const PortSettings& asked) {
    PortSettings any{.port = asked.port, .interrupt = asked.interrupt};
    try {
        static_cast<void>(open_port(any, interface::Command::identify, 2));
    } catch (const LinkLost&) {
        return {};
    }
    return remembered_rate(asked.port);
}

}  // namespace

Device::Device(const PortSettings& settings) try : Client(open_port(settings)) {
    set_interrupt(settings.interrupt);
    identify();
} catch (const LinkLost& lost) {  // the port is closed
    if (!settings.baud || names_udp(settings.port)) throw;
    const auto rate = rate_of(settings);
    if (rate == settings.baud) throw;  // by now it answers
    if (rate)
        throw LinkLost(
            lost.where(),
            fmt::format("no answer to identify at {} baud, but at {}: give that rate, or none, and it is found",
                        *settings.baud, *rate));
    throw LinkLost(lost.where(), fmt::format("{}; nor is there one at another rate than {} baud: {} were tried",
                                             lost.message(), *settings.baud, fmt::join(known_rates, ", ")));
}

std::vector<FoundDevice> devices_behind(const PortSettings& settings) {
    PortSettings behind = settings;
    if (!behind.baud) try {
            static_cast<void>(open_port(behind, interface::Command::identify, 2));
            behind.baud = remembered_rate(behind.port);
        } catch (const LinkLost&) {  // a chain that has begun answers to its tiles' names alone
        }
    std::vector<FoundDevice> found;
    // A tile can be asked while the ones before it have a user; they are kept, so that the port stays open.
    std::vector<std::unique_ptr<Device>> devices;
    try {
        for (unsigned tile = 1; tile <= interface::chain::most_tiles; ++tile) {
            behind.port = name_of({settings.port, tile});
            devices.push_back(std::make_unique<Device>(behind));
            found.push_back({behind.port, devices.back()->identity()});
        }
    } catch (const LinkLost&) {  // the chain ends before this tile
    }
    devices.clear();
    if (found.empty()) found.push_back({settings.port, Device(settings).identity()});
    return found;
}

}  // namespace haptogram::link
