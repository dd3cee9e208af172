// SPDX-License-Identifier: Apache-2.0
// One thread in the place of oneTBB, for the browser; so have the files beside it.
#pragma once
#include <cstddef>
namespace tbb {
struct global_control {
    enum parameter { max_allowed_parallelism };
    static std::size_t active_value(parameter) { return 1; }
};
}  // namespace tbb
