// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/array/rig.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/live/player.hpp"
#include "rig_ports.hpp"

namespace haptogram::cli {

/// A board that a loop plays on, or several of a rig as one, and the clock that it keeps.
class LiveBoard {
public:
    LiveBoard() = default;
    LiveBoard(const LiveBoard&) = delete;
    LiveBoard& operator=(const LiveBoard&) = delete;
    virtual ~LiveBoard() = default;
    [[nodiscard]] virtual link::Commands& client() = 0;
    /// The boards of a rig, with the elements of each; none for one board.
    [[nodiscard]] virtual std::vector<live::DevicePart> parts() { return {}; }
    /// How often they have begun together.
    [[nodiscard]] virtual unsigned beginnings() const { return 0; }
    [[nodiscard]] link::Clock& clock() { return client().clock(); }
    /// Changes of the record at the pins, by the clock; empty when nobody can see the pins.
    [[nodiscard]] virtual std::vector<std::pair<double, std::uint16_t>> starts() const { return {}; }
};

/// The reference board of a configuration in this process. The loop's time is the board's.
/// @throws Error{bad_argument} in a build without simulation, or for no configuration
[[nodiscard]] std::unique_ptr<LiveBoard> reference_board(const std::string& configuration);
/// The same of a rig, with one for each of its arrays. Their crystals differ.
[[nodiscard]] std::unique_ptr<LiveBoard> reference_rig(const std::string& configuration, const Rig& rig,
                                                       const link::RigSettings& settings);

/// The board behind a port, or those of a rig behind several, which play as one.
/// @param rig  if one is named  @param watchdog_ms  as link::RigSettings has it
/// @throws Error{bad_argument} for ports that are too few, too many or of two kinds, Error{device} for boards that
/// cannot be reached or cannot play together
[[nodiscard]] std::unique_ptr<LiveBoard> open_live_board(const RigPorts& ports, const std::optional<Rig>& rig,
                                                         std::uint16_t watchdog_ms);
/// Whether all ports are those of reference boards.
/// @throws Error{bad_argument} when only some are
[[nodiscard]] bool keeps_own_time(const RigPorts& ports);

}  // namespace haptogram::cli
