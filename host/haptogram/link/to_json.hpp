// SPDX-License-Identifier: Apache-2.0
// What this library finds, as JSON objects for programs: the same for the command line and a server.
#pragma once
#include <nlohmann/json.hpp>

#include "haptogram/link/pattern_stream.hpp"
#include "haptogram/link/play.hpp"
#include "haptogram/link/port.hpp"
#include "haptogram/link/rig.hpp"
#include "haptogram/link/transfer.hpp"
#include "haptogram/link/trigger.hpp"

namespace haptogram::link {

[[nodiscard]] nlohmann::ordered_json to_json(const Identity& identity);
[[nodiscard]] nlohmann::ordered_json to_json(const Status& status);
[[nodiscard]] nlohmann::ordered_json to_json(const TriggerSettings& settings);
[[nodiscard]] nlohmann::ordered_json to_json(const TriggerTimes& times, std::uint32_t clock_hz);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<PortInfo>& ports);
[[nodiscard]] nlohmann::ordered_json to_json(const UploadReport& report);
/// Of playing from the device's memories.
[[nodiscard]] nlohmann::ordered_json played_to_json(const Played& played);
/// Of a rig, whose counters are sums over its tiles.
[[nodiscard]] nlohmann::ordered_json to_json(const RigPlayed& played);
/// Of indices that went over the link.
[[nodiscard]] nlohmann::ordered_json streamed_to_json(const Played& played);
[[nodiscard]] nlohmann::ordered_json streamed_to_json(const RigPlayed& played);
[[nodiscard]] nlohmann::ordered_json to_json(const PlayedPatterns& played);

}  // namespace haptogram::link
