// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "haptogram/link/device_state.hpp"

namespace haptogram::studio {

/// The message "device" of a board that there is, or that is being reached.
/// @param baud  of its line; 0: there is none
[[nodiscard]] nlohmann::ordered_json device_json(const link::DeviceState& state, const std::string& port,
                                                 std::uint32_t baud, double intensity);

}  // namespace haptogram::studio
