// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptogram/format/bundle.hpp"

namespace haptogram {

/// One board of a rig: the elements that it drives, and where it is plugged in.
struct TilePart {
    std::string array;         ///< name of its array, for messages
    std::size_t elements = 0;  ///< how many of the rig's elements it drives; channels that are left over are silent
    Core core;
    std::string port;  ///< empty: the caller that plays the rig names it
};

/// The images of a rig, one a tile, and what they are together. All have the same sequence, so that boards that begin
/// in one carrier period play the same focus in every one after it. Elements lie in the rig's frame.
struct RigBundle {
    std::string rig;   ///< its name
    std::string name;  ///< of the rig manifest's file, for messages
    std::vector<TilePart> parts;
    std::vector<Bundle> tiles;  ///< in the order of the rig's units
    Bundle whole;               ///< the same as one image for one board with all elements
};

/// Cuts an image for all elements of a rig into one for each of its boards.
/// @param whole  one channel an element, those of the first tile first
/// @param name   of the rig manifest's file; tile N's image is called after it, tile_image_path()
/// @throws Error{bad_input} when the parts do not have as many elements as the image
[[nodiscard]] RigBundle split(const Bundle& whole, const std::string& rig, std::span<const TilePart> parts,
                              const std::string& name);

/// The image of all tiles together, which split() cuts again into the same tiles.
/// @throws Error{bad_input} naming the tile that has another sequence, timer or set of foci than the first
[[nodiscard]] Bundle joined(std::span<const Bundle> tiles, const std::string& name);

/// Where the image of a tile is: beside the rig manifest wall.json, wall.tile-1.hex. @param tile  counted from 1
[[nodiscard]] std::string tile_image_path(const std::string& rig_manifest, std::size_t tile);

/// The text of the rig manifest: which images the tiles have, by name and hash, which elements they drive, and their
/// ports.
[[nodiscard]] std::string to_text(const RigBundle& bundle);

/// Every file of a rig: the manifest, and each tile's image with its own manifest beside it, so that what works on one
/// board's image works on a tile's.
[[nodiscard]] std::vector<std::pair<std::filesystem::path, std::string>> files_of(const RigBundle& bundle);

/// Whether a file's text is that of a rig manifest, rather than of one image's.
[[nodiscard]] bool is_rig_manifest(std::string_view text);

/// Reads a rig manifest and all images that it names.
/// @throws Error{bad_input} naming the file and the member, also for a tile whose image is another one than when the
/// manifest was written
[[nodiscard]] RigBundle load_rig_bundle(const std::string& path);

}  // namespace haptogram
