// SPDX-License-Identifier: Apache-2.0
#include "report.hpp"

#include <fmt/format.h>

namespace haptogram::cli {

void tell(const nlohmann::ordered_json& report, bool as_json, const std::string& sentence) {
    if (as_json) {
        fmt::print("{}\n", report.dump(1));
        return;
    }
    if (!sentence.empty()) {
        fmt::print("{}\n", sentence);
        return;
    }
    for (const auto& [name, value] : report.items())
        fmt::print("{:16} {}\n", name, value.is_string() ? value.get<std::string>() : value.dump());
}

void Report::print(bool as_json) const {
    if (as_json) {
        fmt::print("{}\n", json_.dump(1));
        return;
    }
    for (const std::string& line : lines_) fmt::print("{}\n", line);
}

}  // namespace haptogram::cli
