// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram {

/// A file that was compiled in; CMake writes the table from the files themselves (host/CMakeLists.txt).
struct ShippedFile {
    std::string_view name;  ///< FOLDER/NAME
    std::string_view content;
};
[[nodiscard]] std::span<const ShippedFile> shipped_table();

}  // namespace haptogram

/// Files that are compiled into the library, so that it finds them wherever it is linked into: arrays, transducers,
/// boards. They are named "shipped:FOLDER/NAME"; read_file() takes such a name like a path.
namespace haptogram {

inline constexpr std::string_view shipped_prefix = "shipped:";

/// The content of a shipped file. @param name  with its prefix, such as "shipped:arrays/tile-10x10.toml"
[[nodiscard]] std::optional<std::string_view> shipped_file(std::string_view name);

/// Names, sorted, of the shipped files in a folder that end in `ending`; without folder and ending.
[[nodiscard]] std::vector<std::string> shipped_names(std::string_view folder, std::string_view ending);

/// @throws Error{bad_input} naming the shipped files whose names contain `name`, when there are any
void require_no_part(const std::string& name, std::string_view folder, std::string_view ending, std::string_view kind);

/// What a user means by `name`: a path when it has a slash or ends in `ending`, else the shipped file of that name.
/// @param kind  what it is, for messages, such as "array"
/// @throws Error{bad_input} naming those that are shipped
[[nodiscard]] std::string path_or_shipped(const std::string& name, std::string_view folder, std::string_view ending,
                                          std::string_view kind);

}  // namespace haptogram
