// SPDX-License-Identifier: Apache-2.0
// What mends a design that is refused.
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "haptogram/verbs/report_page.hpp"

namespace haptogram::studio {

/// Changes of a refused document, each of which was tried: with it alone, all of the document can be made. Numbers are
/// changed as little as it takes, as far as a few attempts tell.
/// @param can_be_made  whether a document can; it may say no when there is no more time
/// @param named        the settings that the refusal names, if any; where they are others and nothing is modulated or
///                     moved, no pace is tried
[[nodiscard]] std::vector<Remedy> ways_out(const nlohmann::ordered_json& document,
                                           const std::function<bool(const nlohmann::ordered_json&)>& can_be_made,
                                           const std::vector<std::string>& named = {});

}  // namespace haptogram::studio
