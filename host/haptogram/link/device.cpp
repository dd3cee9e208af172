// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device.hpp"

#include "haptogram/format/interface.hpp"
#include "haptogram/link/chain.hpp"

namespace haptogram::link {

std::vector<FoundDevice> devices_behind(const PortSettings& settings) {
    std::vector<FoundDevice> found;
    // A tile can be asked while the ones before it have a user; they are kept, so that the port stays open.
    std::vector<std::unique_ptr<Device>> devices;
    try {
        for (unsigned tile = 1; tile <= interface::chain::most_tiles; ++tile) {
            const std::string port = name_of({settings.port, tile});
            devices.push_back(std::make_unique<Device>(PortSettings{port, settings.baud}));
            found.push_back({port, devices.back()->identity()});
        }
    } catch (const LinkLost&) {  // the chain ends before this tile
    }
    devices.clear();
    if (found.empty()) found.push_back({settings.port, Device(settings).identity()});
    return found;
}

}  // namespace haptogram::link
