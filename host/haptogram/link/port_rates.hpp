// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace haptogram::link {

/// The rate at which a board has answered behind this port, in this process or as another one noted it in
/// $XDG_STATE_HOME/haptogram/ports; none when that is not known.
[[nodiscard]] std::optional<std::uint32_t> remembered_rate(const std::string& port);
/// Notes it. A file that cannot be written is left as it is.
void remember_rate(const std::string& port, std::uint32_t baud);

}  // namespace haptogram::link
