// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "haptogram/link/memory.hpp"
#include "haptogram/link/outputs.hpp"

namespace haptogram::link {

/// A stretch of a device's address space.
struct Stretch {
    std::uint32_t address = 0;
    std::size_t bytes = 0;
};

/// What a device held when this was made, and holds again when it goes, whatever was written meanwhile.
class KeptMemory {
public:
    /// Reads what shall be kept.
    /// @param warn  told when it could not be written back
    KeptMemory(Commands& device, const std::vector<Stretch>& stretches, Warning warn, const Progress& progress = {});
    KeptMemory(const KeptMemory&) = delete;
    KeptMemory& operator=(const KeptMemory&) = delete;
    ~KeptMemory();

private:
    Commands& device_;
    std::vector<Piece> pieces_;
    Warning warn_;
};

}  // namespace haptogram::link
