// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json.hpp>

#include "haptogram/live/loop.hpp"

namespace haptogram::live {

/// What happened in a shot, lengths in mm.
[[nodiscard]] nlohmann::ordered_json to_json(const ShotReport& shot);
/// What became of a run. The latency stands in it when rings were seen at the pins.
[[nodiscard]] nlohmann::ordered_json to_json(const LoopReport& report, const Latency& latency);

}  // namespace haptogram::live
