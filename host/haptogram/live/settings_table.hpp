// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace haptogram::live {

/// A key of a table, its value as a command line has it, and where it stands.
struct TableEntry {
    std::string key, value, where;
};
/// A table of a TOML file. A list is its parts with commas between.
/// @throws Error{bad_input} for a file without that table
[[nodiscard]] std::vector<TableEntry> settings_table(const std::string& file, const std::string& table);

}  // namespace haptogram::live
