// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "../test_data.hpp"

/// Depth frames of a real hand that are not part of the repository, in a folder beside it; empty when it is not there.
inline std::filesystem::path recorded_depth() {
    const auto folder =
        std::filesystem::path(test_data()).parent_path().parent_path().parent_path() / "shared/data/depth";
    return std::filesystem::exists(folder) ? folder : std::filesystem::path{};
}
