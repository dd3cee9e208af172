// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/token.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>

#include "haptogram/base/error.hpp"

namespace haptogram {

std::string make_token() {
    std::array<unsigned char, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        throw Error(ErrorCode::failed, "token", "the system gives no random numbers");
    return fmt::format("{:02x}", fmt::join(bytes, ""));
}

bool is_token(std::string_view found, std::string_view expected) {
    if (found.size() != expected.size()) return false;
    unsigned char difference = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
        difference = static_cast<unsigned char>(difference | (found[i] ^ expected[i]));
    return difference == 0;
}

}  // namespace haptogram
