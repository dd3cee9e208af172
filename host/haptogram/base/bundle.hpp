// SPDX-License-Identifier: Apache-2.0
// A bundle: one zip file, NAME.haptogram, with a project.toml and all files that it names. Nothing is unpacked to the
// disk: read_file() takes "NAME.haptogram/heart.ply" for the file in it, so that every reader does.
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace haptogram {

inline constexpr std::size_t most_bundled_bytes = 256 * 1024 * 1024;  ///< of one file, unpacked

/// Whether a name is that of a bundle.
[[nodiscard]] bool is_bundle(const std::filesystem::path& path);

/// The content of a file in a bundle; none when no folder of the path is one.
/// @throws Error{bad_input} when the bundle cannot be read, has no such file, or the file is larger than a bundle's may
/// be or than the bundle says
[[nodiscard]] std::optional<std::string> read_bundled(const std::filesystem::path& path);

/// The content of a file in a zip file that is in memory, whatever the case of its name; none when it has no such file.
/// @throws Error{bad_input} as read_bundled()
[[nodiscard]] std::optional<std::string> read_zipped(std::string_view zip, const std::string& inside,
                                                     const std::string& where);

/// A file that a file in `folder` names. What lies in a bundle, or in a folder that is called like one, may name files
/// in it alone.
/// @throws Error{bad_input} when a file of a bundle names one of this machine
[[nodiscard]] std::filesystem::path named_in(const std::filesystem::path& folder, const std::filesystem::path& name);

}  // namespace haptogram
