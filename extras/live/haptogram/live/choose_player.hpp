// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "haptogram/array/array.hpp"
#include "haptogram/format/method.hpp"
#include "haptogram/live/focus_player.hpp"
#include "haptogram/live/player.hpp"

namespace haptogram::live {

/// What shall be played.
struct PlayerOptions {
    Method method = Method::distance_weighted;  ///< of several foci at once, where records are sent
    std::size_t steps = 0;                      ///< of a path in records; 0: as many as line and board take
    FocusPace pace{};                           ///< where foci are sent
    double rate_hz = 30.0;                      ///< of frames
    bool slow = false;                          ///< a pass takes seconds
    std::uint16_t watchdog_ms = 500;
    std::vector<DevicePart> parts{};  ///< of a rig's boards; none: the device is one
};

/// A player, and what board and line can do for it.
struct ChosenPlayer {
    std::unique_ptr<Player> player;
    std::string about;
    double interval_s = 0.0;  ///< for LoopOptions: what a path takes on the line
    std::string shortfall{};  ///< what they cannot keep up with; empty when they can
};

/// Foci where the board computes them for this array, and records elsewhere.
/// @throws Error{bad_input} when several boards cannot keep the array's carrier together, Error{device} when the line
/// takes too long for a path's records to follow a hand
[[nodiscard]] ChosenPlayer choose_player(link::Commands& device, link::Clock& clock, const Array& array,
                                         const PlayerOptions& options);

}  // namespace haptogram::live
