// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// What a board with these parameters says that it is.
[[nodiscard]] std::array<std::uint16_t, interface::identity_words> identity_block(const interface::CoreParameters& p);
/// The same as it is sent.
[[nodiscard]] std::vector<std::uint8_t> identity_bytes(const interface::CoreParameters& p);

}  // namespace haptogram::sim
