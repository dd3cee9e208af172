// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "child.hpp"
#include "messages.hpp"
#include "virtual_board.hpp"

/// Studies with people. Orders, questions, checks and results are those of Python's haptogram_study; here is only the
/// way between its runner and a page.
namespace haptogram::studio {

/// The protocols that are shipped, and those in a folder, as `haptogram-study list --json` prints them.
/// @throws Error{failed} with Python's own words when the runner cannot be started
[[nodiscard]] nlohmann::ordered_json study_protocols(const std::filesystem::path& folder);

/// The command that runs a participant's session in a folder. @param port  none: nothing is played
[[nodiscard]] Child::Command study_command(const StudyMessage& asked, const std::filesystem::path& folder,
                                           const std::optional<BoardPort>& port);

}  // namespace haptogram::studio
