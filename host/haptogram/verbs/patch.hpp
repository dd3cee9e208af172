// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "haptogram/base/progress.hpp"
#include "haptogram/verbs/path_makers.hpp"

namespace haptogram {

struct PatchOptions {
    std::string board;                   ///< name of a shipped board, or its file
    std::optional<std::string> image;    ///< image or project; none: empty memories, to be filled over the link
    std::optional<unsigned> rx_delay{};  ///< instead of the board's, of its network's inputs, in steps of 25 ps
    bool autostart = false;              ///< the board plays the image at power-up, with no host and no watchdog
    PathMakers makers{};                 ///< for a project as the image
    std::filesystem::path placed = "build/boards";  ///< folder of what tools/bitstream.py placed, a folder a board
};

/// A bitstream, and what is in it, as JSON.
struct Patched {
    std::string bitstream, manifest;
};

/// Puts an image into the block RAMs of a bitstream that was placed once, without placing it again; and another delay
/// into its network's inputs, of which whoever has a new board tries some. It calls the packers of IceStorm or Project
/// Trellis.
/// @throws Error{bad_input} when the image does not fit the board or nothing was placed, Error{failed} when a packer
/// fails or the placed design is not what its files say
[[nodiscard]] Patched patch(const PatchOptions& options, const Progress& progress = {});

/// What a board with an SDRAM reads out of its flash at power-up, in the place of a bitstream, and where it goes.
/// Nothing is placed for it.
/// @throws Error{bad_input} when the image does not fit the board or its flash
[[nodiscard]] Patched flash_contents(const PatchOptions& options);

}  // namespace haptogram
