// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace haptogram::cli {

/// Prints a report: as JSON, or as a sentence, or without one as a line "name  value" for each of its values.
void tell(const nlohmann::ordered_json& report, bool as_json, const std::string& sentence = {});

}  // namespace haptogram::cli
