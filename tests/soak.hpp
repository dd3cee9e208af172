// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdlib>

namespace haptogram::test {

/// How much of a random run a case does: `full` in a soak (HAPTOGRAM_SOAK=1, as in `make soak`), `quick` otherwise.
inline std::size_t soaked(std::size_t full, std::size_t quick) {
    return std::getenv("HAPTOGRAM_SOAK") != nullptr ? full : quick;
}

}  // namespace haptogram::test
