// SPDX-License-Identifier: Apache-2.0
#include "haptogram/base/token.hpp"

#include <fmt/format.h>

#include <random>

namespace haptogram {

std::string make_token() {
    std::random_device random;  // of the processor or the system, no sequence
    return fmt::format("{:08x}{:08x}{:08x}{:08x}", random(), random(), random(), random());
}

bool is_token(std::string_view found, std::string_view expected) {
    if (found.size() != expected.size()) return false;
    unsigned char difference = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
        difference = static_cast<unsigned char>(difference | (found[i] ^ expected[i]));
    return difference == 0;
}

}  // namespace haptogram
