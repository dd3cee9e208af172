// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace haptogram::serve {

inline constexpr std::size_t most_body_bytes = 64 * 1024 * 1024;

/// What a page asks for, as HTTP says it; a page without a server asks the same.
struct Request {
    std::string method, path, query;
    std::string body;
    bool takes_gzip = false;
};

struct Answer {
    unsigned status = 200;
    std::string type = "application/json";
    std::string body;
    bool gzip = false;  ///< how the body is encoded
};

/// {"error": {"message": …}}. Bytes of the message that are no UTF-8 become U+FFFD.
[[nodiscard]] Answer error_answer(unsigned status, const std::string& message);

/// The value of a query's parameter, with %XX decoded. @return none when it is not there or wrongly encoded
[[nodiscard]] std::optional<std::string> query_value(std::string_view query, std::string_view name);

}  // namespace haptogram::serve
