// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "frame_pins.hpp"
#include "haptogram/verbs/compile.hpp"
#include "report.hpp"

namespace haptogram::cli {

/// A frame of a run, and what the simulated board made of it.
struct PlayedFrame {
    std::size_t number;  ///< of the run, from 0
    PinsOfFrame pins;
    bool good;  ///< no contract is broken, the bursts have the frequency, and the pulses the length that was asked
};

/// Plays some of the frames in which something is felt, evenly over the run, on the simulated board.
/// @throws Error as pins_of()
[[nodiscard]] std::vector<PlayedFrame> play_some(const std::vector<const fusion::Frame*>& frames, std::uint64_t count,
                                                 const ProjectInstrument& instrument, const perception::Tables& tables);

/// What was asked of a frame and what came out.
/// @param time_s  of its end in the run
[[nodiscard]] nlohmann::ordered_json to_json(const PlayedFrame& played, const fusion::Frame& frame, double time_s);
/// The same in a line, and a line for each violation.
void tell(Report& report, const PlayedFrame& played, const fusion::Frame& frame, double time_s);

}  // namespace haptogram::cli
