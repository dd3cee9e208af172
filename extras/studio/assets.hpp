// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <string>

namespace haptogram::studio {

/// One file of the page.
struct Asset {
    std::string type;   ///< of its content, as HTTP says it
    std::string plain;  ///< the file
    std::string gzip;   ///< the same, compressed; empty when there is none
};

/// The page's files by their path, such as "/boot.js"; "/" is the page. They are read once, so that no request ever
/// names a file.
using Assets = std::map<std::string, Asset, std::less<>>;

/// Reads what web/build.mjs wrote. Its list, page.json, has the hash of every file.
/// @throws Error{bad_input} for a file that is missing or is not the one of the list
[[nodiscard]] Assets load_assets(const std::filesystem::path& folder);

/// A page that says what is missing, when the page was not built. @param looked_in  the folders that were tried
[[nodiscard]] Assets assets_without_page(const std::string& looked_in);

}  // namespace haptogram::studio
