// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

#include "haptogram/verbs/path_makers.hpp"

namespace haptogram {

/// The path of an AdapTics pattern, with the points and parameters of a project.
/// @throws Error as path_from_adaptics()
[[nodiscard]] RenderedPath path_of_pattern(const Project& project, std::string_view text, const std::string& where,
                                           double carrier_hz);

}  // namespace haptogram
