// SPDX-License-Identifier: Apache-2.0
#include "report.hpp"

#include <fmt/core.h>

namespace haptogram::cli {

void Report::print(bool as_json) const {
    if (as_json) {
        fmt::print("{}\n", json_.dump(1));
        return;
    }
    for (const std::string& line : lines_) fmt::print("{}\n", line);
}

}  // namespace haptogram::cli
