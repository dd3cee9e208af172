// SPDX-License-Identifier: Apache-2.0
// A project file as JSON: the same keys with the same values, for front ends that speak JSON.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace haptogram {

/// The settings of a project file as a JSON object with the file's own keys.
/// @param where  names the text in messages
/// @throws Error{bad_input} as project_from_toml(), which has the last word on every key
[[nodiscard]] nlohmann::ordered_json document_of(std::string_view toml, const std::string& where);

/// The text of a project file with a document's keys and values. It does not know the keys of a project: whether they
/// make sense is for project_from_toml() to say.
/// @throws Error{bad_input} for what no project file has: null, or tables deeper than one level
[[nodiscard]] std::string toml_of(const nlohmann::ordered_json& document);

}  // namespace haptogram
