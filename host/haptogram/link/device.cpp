// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device.hpp"

#include <fmt/format.h>

#include "haptogram/format/interface.hpp"
#include "haptogram/link/chain.hpp"
#include "haptogram/link/port_rates.hpp"

namespace haptogram::link {

Device::Device(const PortSettings& settings) : Client(open_port(settings)) {
    set_interrupt(settings.interrupt);
    try {
        identify();
    } catch (const LinkLost& lost) {
        if (!settings.baud) throw;
        throw LinkLost(lost.where(), fmt::format("{}; only {} baud was tried, as asked; without a rate, {} are",
                                                 lost.message(), *settings.baud, fmt::join(known_rates, ", ")));
    }
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
