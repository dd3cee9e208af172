// SPDX-License-Identifier: Apache-2.0
#include "request.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

namespace haptogram::serve {

Answer error_answer(unsigned status, const std::string& message) {
    const nlohmann::json answer{{"error", {{"message", message}}}};
    return {status, "application/json", answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)};
}

std::optional<std::string> query_value(std::string_view query, std::string_view name) {
    while (!query.empty()) {
        const std::size_t end = std::min(query.find('&'), query.size());
        const std::string_view part = query.substr(0, end);
        query.remove_prefix(std::min(end + 1, query.size()));
        const std::size_t equals = std::min(part.find('='), part.size());
        if (part.substr(0, equals) != name || equals == part.size()) continue;
        std::string value;
        for (std::string_view rest = part.substr(equals + 1); !rest.empty(); rest.remove_prefix(1)) {
            if (rest.front() != '%') {
                value += rest.front();
                continue;
            }
            unsigned byte = 0;
            if (rest.size() < 3) return {};
            const auto [after, error] = std::from_chars(rest.data() + 1, rest.data() + 3, byte, 16);
            if (error != std::errc() || after != rest.data() + 3) return {};
            value += static_cast<char>(byte);
            rest.remove_prefix(2);
        }
        return value;
    }
    return {};
}

}  // namespace haptogram::serve
