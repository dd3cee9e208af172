// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/format/rig_bundle.hpp"
#include "haptogram/link/device.hpp"
#include "haptogram/link/rig.hpp"

namespace haptogram::link {

/// Where the devices of a rig are.
/// @param ports  one a tile, in the order of tiles; empty: those that the rig names; one alone: a chain of all tiles
/// @param baud   of all; none: what the board of each tile has is likely
/// @throws Error{bad_argument} naming "port" when there are more or fewer ports than tiles, or one port twice
[[nodiscard]] std::vector<PortSettings> ports_of(const RigBundle& bundle, const std::vector<std::string>& ports,
                                                 std::optional<std::uint32_t> baud = {});

/// A tile's name in messages. @param tile  counted from 0
[[nodiscard]] std::string name_of_tile(std::size_t tile, const std::string& port);

/// The devices of a rig, a session begun with each. The bundle must outlive them.
class RigDevices {
public:
    /// @throws Error{device} naming the tile whose port cannot be opened, or that does not answer
    RigDevices(const RigBundle& bundle, const std::vector<PortSettings>& ports);

    [[nodiscard]] std::span<const Tile> tiles() const { return tiles_; }

private:
    std::vector<std::unique_ptr<Device>> devices_;
    std::vector<Tile> tiles_;
};

}  // namespace haptogram::link
