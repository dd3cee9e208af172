// SPDX-License-Identifier: Apache-2.0
#include "haptogram/link/device_state.hpp"

namespace haptogram::link {

std::string_view to_string(Connection connection) {
    constexpr std::string_view names[] = {"connecting", "connected", "lost"};
    return names[static_cast<unsigned>(connection)];
}

}  // namespace haptogram::link
