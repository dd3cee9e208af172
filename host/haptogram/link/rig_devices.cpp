// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/rig_devices.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "haptogram/base/error.hpp"
#include "haptogram/link/chain.hpp"

namespace haptogram::link {

std::vector<PortSettings> ports_of(const RigBundle& bundle, const std::vector<std::string>& ports,
                                   std::optional<std::uint32_t> baud) {
    const bool chained = ports.size() == 1 && bundle.tiles.size() > 1 && !chained_port(ports.front());
    if (!ports.empty() && !chained && ports.size() != bundle.tiles.size())
        throw bad_argument("port", fmt::format("{} given, but the rig {} has {} tiles; give one for each, in their "
                                               "order, or one alone that leads to a chain of them",
                                               ports.size(), bundle.rig, bundle.tiles.size()));
    std::vector<PortSettings> settings;
    for (std::size_t i = 0; i < bundle.tiles.size(); ++i) {
        const TilePart& part = bundle.parts[i];
        const std::string port = chained         ? name_of({ports.front(), static_cast<unsigned>(i + 1)})
                                 : ports.empty() ? part.port
                                                 : ports[i];
        if (port.empty())
            throw bad_argument("port", fmt::format("the rig {} names none for tile {} of {}; give one for each tile, "
                                                   "in their order, or name them in the rig's file and compile again",
                                                   bundle.rig, i + 1, bundle.tiles.size()));
        if (std::ranges::find(settings, port, &PortSettings::port) != settings.end())
            throw bad_argument("port", fmt::format("{} is given for two tiles; each has a port of its own", port));
        settings.push_back({.port = port, .baud = baud, .likely = part.core.parameters.baud});
    }
    return settings;
}

std::string name_of_tile(std::size_t tile, const std::string& port) {
    return fmt::format("tile {} ({})", tile + 1, port);
}

RigDevices::RigDevices(const RigBundle& bundle, const std::vector<PortSettings>& ports) {
    for (std::size_t i = 0; i < ports.size(); ++i) {
        const std::string name = name_of_tile(i, ports[i].port);
        try {
            devices_.push_back(std::make_unique<Device>(ports[i]));
        } catch (const Error& error) {
            throw Error(error.code(), name, error.message());
        }
        tiles_.push_back({*devices_.back(), bundle.tiles[i].image, name});
    }
}

}  // namespace haptogram::link
