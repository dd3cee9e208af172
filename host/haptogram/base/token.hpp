// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

namespace haptogram {

/// 128 bits from the system's random source, as 32 hexadecimal digits. @throws Error{failed} when there is none
[[nodiscard]] std::string make_token();

/// Whether a token is the right one, in a time that does not tell how much of it is right.
[[nodiscard]] bool is_token(std::string_view found, std::string_view expected);

}  // namespace haptogram
