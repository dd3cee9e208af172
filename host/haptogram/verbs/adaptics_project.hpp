// SPDX-License-Identifier: Apache-2.0
#pragma once
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

}  // namespace haptogram
