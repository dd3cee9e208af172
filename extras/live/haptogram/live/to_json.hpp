// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json.hpp>

#include "haptogram/live/lift_task.hpp"
#include "haptogram/live/loop.hpp"
#include "haptogram/live/surface_task.hpp"

namespace haptogram::live {

/// What happened in a frame, lengths in mm, as the table in extras/live/README.md has it.
/// @param path  that plays since then, if any
[[nodiscard]] nlohmann::ordered_json to_json(const ShotReport& shot, const Frame& frame,
                                             const std::optional<Path>& path);
/// What became of a run. The latency stands in it when rings were seen at the pins, and as stamped_latency_ms when the
/// device counts carrier periods.
[[nodiscard]] nlohmann::ordered_json to_json(const LoopReport& report, const Latency& latency);
/// The same, with every ring that went to the device and when it began.
[[nodiscard]] nlohmann::ordered_json run_to_json(const LoopReport& report, const Latency& latency);

/// A trial of a task: what was asked, and what came of it.
[[nodiscard]] nlohmann::ordered_json to_json(const LiftOptions& asked, const LiftReport& report);
[[nodiscard]] nlohmann::ordered_json to_json(const SurfaceOptions& asked, const SurfaceReport& report);

}  // namespace haptogram::live
