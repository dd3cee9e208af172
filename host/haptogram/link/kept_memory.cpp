// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/kept_memory.hpp"

#include <fmt/format.h>

#include <exception>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/format/image.hpp"

namespace haptogram::link {

KeptMemory::KeptMemory(Commands& device, const std::vector<Stretch>& stretches, Warning warn, const Progress& progress)
    : device_(device), warn_(std::move(warn)) {
    const std::size_t frame = std::size_t{2} * record_words(device.identity().channels) / 4 * 4;
    for (const Stretch& stretch : stretches)
        cut(pieces_, stretch.address, contents(device, stretch.address, stretch.bytes, progress), frame);
}

KeptMemory::~KeptMemory() {
    try {
        device_.pipeline(writing(differing(device_, pieces_)));
    } catch (const Error& error) {
        if (!warn_) return;
        try {
            warn_(
                fmt::format("{}; the board's memory still holds a test pattern: upload the image again", error.what()));
        } catch (const std::exception&) {
            // A warning that cannot be given must not end the program while it cleans up.
        }
    }
}

}  // namespace haptogram::link
