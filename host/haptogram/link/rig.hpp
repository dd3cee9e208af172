// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/format/image.hpp"
#include "haptogram/link/client.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {

// Several devices that play as one, each its own image of a rig (format/rig_bundle.hpp). They are kept in step over the
// wire SYNC: the first gives the time, the others follow it (docs/tiles.md). All of this runs in the caller's thread.

/// One device of a rig.
struct Tile {
    Client& device;
    const Image& image;
    std::string name;  ///< in messages, such as "tile 2 (/dev/ttyUSB1)"
};

/// What becomes of the others when one tile falls silent, falls out of step, or turns its outputs off.
enum class OnLoss {
    off,   ///< all go off
    rest,  ///< the rest go on
};

struct RigSettings {
    std::uint16_t index = 0;               ///< one record, until it is ended; 0: the sequence
    std::optional<std::uint16_t> loops{};  ///< passes over the sequence, 0 for ever; without: as the image says
    double seconds = 0.0;                  ///< not longer than this; 0: no limit
    std::uint16_t watchdog_ms = 500;       ///< a tile's outputs go off when this host is silent for so long; 0: never
    OnLoss on_loss = OnLoss::off;
    Warning warn{};
};

/// What goes on while a rig plays.
struct RigPlaying {
    double seconds = 0.0;                         ///< since it began
    std::uint64_t sent = 0;                       ///< of a stream: entries that went to each tile
    std::vector<std::optional<Status>> statuses;  ///< one a tile, as it said last; empty for a lost one
};

/// Told what goes on at least every keep_alive_pause(); false ends the playing in good order.
using RigWatch = std::function<bool(const RigPlaying&)>;

/// What became of it. Counters are sums over the tiles.
struct RigPlayed {
    std::uint64_t sent = 0;    ///< of a stream: entries that went to each tile
    std::uint64_t period = 0;  ///< the carrier period in which all tiles began
    unsigned attempts = 0;     ///< until one was agreed on that none missed; of a stream, the most
    std::uint64_t underruns = 0, refused_records = 0, watchdog_trips = 0, guard_trips = 0;
    std::vector<std::string> lost;  ///< tiles that did not stay to the end, with on_loss = rest
    bool interrupted = false;       ///< the watch ended it
};

/// Whether each tile holds its own image, told by its digests. What cannot be read back, the geometry of foci, is
/// written again.
/// @throws Error{device} naming the first tile that does not, and the tile whose image it has instead, if any
void require_images(std::span<const Tile> tiles);

/// Puts the tiles in step: the first becomes the master, the others slaves, unless they are already. A new role resets
/// a device, so its outputs go off.
/// @throws Error{device} naming the tile that has no SYNC or no schedule, or does not come into step
void keep_together(std::span<const Tile> tiles);

/// Checks all tiles (require_images, keep_together), and only then turns any outputs on; plays what their memories
/// hold, from an agreed carrier period on, until its end; and turns all outputs off again, whatever ended it.
/// @throws Error{device} naming the tile that is not as it must be, or was lost while the others should not go on
RigPlayed play(std::span<const Tile> tiles, const RigSettings& settings, const RigWatch& watch = {});

}  // namespace haptogram::link
