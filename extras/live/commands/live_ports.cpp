// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "command.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/rig_commands.hpp"
#include "haptogram/link/rig_devices.hpp"
#include "haptogram/verbs/rig.hpp"
#include "live_board.hpp"
#include "port.hpp"

namespace haptogram::cli {
namespace {

bool is_reference(const std::string& port) { return port.starts_with(link::reference_prefix); }

std::string configuration_of(const std::string& port) { return port.substr(link::reference_prefix.size()); }

class PortBoard final : public LiveBoard {
public:
    explicit PortBoard(const link::PortSettings& port) : device_(port) {}
    link::Commands& client() override { return device_; }

private:
    link::Device device_;
};

class PortRig final : public LiveBoard {
public:
    PortRig(const Rig& rig, const RigPorts& ports, const link::RigSettings& settings)
        : bundle_(boards_of(rig)), devices_(bundle_, ports.of(bundle_)), rig_(devices_.tiles(), settings) {}
    link::Commands& client() override { return rig_; }
    [[nodiscard]] std::vector<live::DevicePart> parts() override {
        std::vector<live::DevicePart> parts;
        for (std::size_t i = 0; i < bundle_.parts.size(); ++i)
            parts.push_back({devices_.tiles()[i].device, bundle_.parts[i].elements});
        return parts;
    }
    [[nodiscard]] unsigned beginnings() const override { return rig_.beginnings(); }

private:
    RigBundle bundle_;
    link::RigDevices devices_;
    link::RigCommands rig_;
};

/// Whether each array has a board of its own, rather than all of them the channels of one.
bool has_boards(const RigPorts& ports, const Rig& rig) {
    return ports.ports.empty() ? rig.arrays.size() > 1 && !rig.boards.empty() : ports.ports.size() > 1;
}

}  // namespace

bool keeps_own_time(const RigPorts& ports) {
    const auto references = std::ranges::count_if(ports.ports, is_reference);
    if (references > 0 && static_cast<std::size_t>(references) < ports.ports.size())
        throw bad_argument("port", "some are of reference boards, whose time is not that of the others");
    return references > 0;
}

std::unique_ptr<LiveBoard> open_live_board(const RigPorts& ports, const std::optional<Rig>& rig,
                                           std::uint16_t watchdog_ms) {
    const bool own_time = keeps_own_time(ports);
    const link::RigSettings settings{.watchdog_ms = watchdog_ms, .warn = complain};
    if (!rig || !has_boards(ports, *rig)) {
        const link::PortSettings port = ports.one();
        if (own_time) return reference_board(configuration_of(port.port));
        warn_of_latency(port.port);
        return std::make_unique<PortBoard>(port);
    }
    if (!own_time) return std::make_unique<PortRig>(*rig, ports, settings);
    if (ports.ports.size() != rig->arrays.size())
        throw bad_argument("port", fmt::format("{} given, but the rig {} has {} arrays; give one for each",
                                               ports.ports.size(), rig->name, rig->arrays.size()));
    if (std::ranges::count(ports.ports, ports.ports.front()) != std::ssize(ports.ports))
        throw bad_argument("port", "the reference boards of a rig are of one configuration");
    return reference_rig(configuration_of(ports.ports.front()), *rig, settings);
}

}  // namespace haptogram::cli
