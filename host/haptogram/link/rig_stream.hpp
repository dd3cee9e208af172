// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "haptogram/base/progress.hpp"
#include "haptogram/link/rig.hpp"
#include "haptogram/link/source.hpp"

namespace haptogram::link {

/// Checks all tiles as play() does, turns their outputs on, and plays entries through the live FIFOs of all of them, no
/// faster than the slowest tile takes them, until they end; then off again. An entry is the same record number on every
/// tile, each with its own image, and plays in the same carrier periods on all.
///
/// The first entry begins in an agreed period. What follows goes to all tiles, and they stay together, because an entry
/// lasts as many periods on each. After an entry of dwell 0, and after a tile has run out of entries, the tiles hold
/// their records and begin together anew, in another agreed period. That takes some exchanges with all of them.
/// @param settings  index and loops are of no use here
/// @throws as play(); Error{bad_input} for an entry that the images have no record for
RigPlayed stream(std::span<const Tile> tiles, const RigSettings& settings, StreamSource& source,
                 const RigWatch& watch = {});

/// Writes the records, foci and modulation of each tile's image into it, and streams the sequence that all have, which
/// may be longer than their memories. The sequences in these are emptied, as their records are no longer there.
/// @param loops     passes; 0: until the watch ends it
/// @param progress  of the writing
RigPlayed stream(std::span<const Tile> tiles, const RigSettings& settings, std::uint64_t loops,
                 const Progress& progress = {}, const RigWatch& watch = {});

/// The highest index that an image has a record for.
[[nodiscard]] std::uint32_t highest_index(const Image& image);

/// Which records the images of a rig have, for a message.
[[nodiscard]] std::string records_in_words(const Image& image);

}  // namespace haptogram::link
