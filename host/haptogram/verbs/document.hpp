// SPDX-License-Identifier: Apache-2.0
// A project file as JSON: the same keys with the same values, for front ends that speak JSON.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "haptogram/verbs/project.hpp"

namespace haptogram {

/// A pattern of the AdapTics designer as a project whose shape, a point or a circle, moves by its key frames, where
/// they can be edited. Played, it is what the pattern is as a path (shape/adaptics.hpp), at most 1000 times a second
/// anew.
/// @throws Error{bad_input} as frames_from_adaptics(), and for a circle that lasts longer than boards can play it
[[nodiscard]] Project project_from_adaptics(std::string_view text, const std::string& where);

/// Whether a text is meant to be such a pattern.
[[nodiscard]] bool is_adaptics(std::string_view text);

/// The settings of a project file as a JSON object with the file's own keys.
/// @param where  names the text in messages
/// @throws Error{bad_input} as project_from_toml(), which has the last word on every key
[[nodiscard]] nlohmann::ordered_json document_of(std::string_view toml, const std::string& where);

/// The text of a project file with a document's keys and values. It does not know the keys of a project: whether they
/// make sense is for project_from_toml() to say.
/// @throws Error{bad_input} for what no project file has: null, or tables deeper than one level
[[nodiscard]] std::string toml_of(const nlohmann::ordered_json& document);

}  // namespace haptogram
