// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string_view>

namespace haptogram {

/// A file that was compiled in; CMake writes the table from the files themselves (host/CMakeLists.txt).
struct ShippedFile {
    std::string_view name;  ///< FOLDER/NAME
    std::string_view content;
};
[[nodiscard]] std::span<const ShippedFile> shipped_table();

}  // namespace haptogram
