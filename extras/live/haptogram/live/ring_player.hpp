// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/timer.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/live/player.hpp"
#include "haptogram/solve/solver.hpp"

namespace haptogram::live {

/// Plays a ring over and over on a device, and replaces it by another as a whole, where a turn ends.
///
/// Each ring has records of its own in the device's memory, and turns go through the live FIFO, whole ones only.
/// Records are written again only after all turns with them have left the FIFO and another ring has begun. So whatever
/// is lost or late, no turn has steps of two rings. The FIFO holds little more than a turn, which is what a new ring
/// waits.
class RingPlayer final : public Player {
public:
    /// @param steps   of every ring
    /// @param method  for several foci at a time, by phases alone
    /// @param watchdog_ms  of the device, which hears from here in time, silent or not
    /// @param parts   of the device, each with the elements of its own; none: it is one board
    /// @throws Error{bad_input} when a board has too few channels for the array, or too few records or FIFO places
    RingPlayer(link::Commands& device, link::Clock& clock, const Array& array, std::size_t steps, Method method,
               std::uint16_t watchdog_ms = 500, const std::vector<DevicePart>& parts = {});

    /// What plays goes on until the new ring is complete.
    /// @param ring  without a modulation; one of other steps is played in those of all rings
    /// @throws Error{bad_argument} for a modulation, Error{bad_input} for foci that cannot be made
    void replace(const Path& ring, std::uint64_t shot, double shot_s) override;
    /// Where the present turn ends.
    void silence() override;
    /// In two steps, each a ring of its own.
    void fade() override;
    bool service() override;
    [[nodiscard]] bool sending() const override { return next_.has_value(); }
    [[nodiscard]] bool playing() const override { return present_.has_value(); }
    [[nodiscard]] bool fading() const override { return !fades_.empty() || (present_ && present_->faded); }

private:
    struct Ring {
        Path path;
        SentRing about;
        std::size_t bank = 0;
        /// What is left to be written, the last one first, and to which part.
        std::vector<std::pair<std::size_t, link::Request>> writes;
        std::vector<std::uint16_t> indices;
        std::uint16_t dwell = 0;
        bool begun = false;  ///< a turn of it was pushed
        bool faded = false;  ///< it is a weaker copy
        /// The first step that sounds; 0 when none does.
        [[nodiscard]] std::size_t first_loud() const {
            const auto loud =
                std::find_if(path.steps.begin(), path.steps.end(), [](const PathStep& s) { return !s.foci.empty(); });
            return loud == path.steps.end() ? 0 : static_cast<std::size_t>(loud - path.steps.begin());
        }
    };

    [[nodiscard]] Ring made(const Path& path, std::uint64_t shot, double shot_s) const;
    [[nodiscard]] std::optional<std::size_t> free_bank() const;
    void give_bank(Ring& ring, std::size_t bank) const;
    void bring();
    void push_turn();

    Array array_;
    std::vector<DevicePart> parts_;
    std::size_t steps_;
    Method method_;
    std::vector<std::uint64_t> free_at_;  ///< of each bank: how many entries must have left the FIFO
    std::optional<Ring> present_, next_;
    std::deque<Path> fades_;
};

}  // namespace haptogram::live
