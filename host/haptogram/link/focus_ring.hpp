// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptogram/format/focus_engine.hpp"
#include "haptogram/link/commands.hpp"

namespace haptogram::link {

/// Where a device keeps the foci that are pushed to it.
struct FocusRing {
    std::uint16_t base = 0;   ///< in primary memory, in units of four words
    std::uint16_t first = 0;  ///< index of its first focus record
    std::uint16_t count = 0;  ///< focus records in it
    std::uint32_t each = 1;   ///< foci of each
    friend bool operator==(const FocusRing&, const FocusRing&) = default;
};

/// Lays the ring behind everything else at the end of primary memory, and makes its records known to the device. An
/// image of foci must have been uploaded, which says where the channels are and how many foci a record has; it stays.
/// @throws Error{device} when the device takes no foci while it plays, holds no image of foci, or has no room for a
/// ring
FocusRing make_ring(Commands& device);

/// Appends a record of the ring that plays one focus: the others of it are the same one at amplitude 0.
void add_record(std::vector<std::uint16_t>& words, FocusWords focus, std::size_t each);

}  // namespace haptogram::link
