// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haptogram {

/// A key of a project's table [live], which is an option of `haptogram live` with _ for -, and its value: as the file
/// has it, as a command line has its parts, and where it stands. `haptogram live` knows which keys there are.
struct LiveSetting {
    std::string key, toml;
    std::vector<std::string> parts;
    std::string where;
};

/// That table of a project file, a bundle, or a TOML file that has nothing else.
/// @throws Error{bad_input} naming the file, the line and the key, also for a file without that table
[[nodiscard]] std::vector<LiveSetting> load_live_table(const std::string& path);
/// @param where  names the text in messages  @return nothing of a text without that table
[[nodiscard]] std::vector<LiveSetting> live_table_from_toml(std::string_view text, const std::string& where);

/// The table's text, with its heading; empty for no settings.
[[nodiscard]] std::string to_toml(std::span<const LiveSetting> settings);

}  // namespace haptogram
