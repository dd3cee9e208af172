// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/bundle.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/link/focus_ring.hpp"
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

/// What a player of foci is for.
struct FocusPace {
    std::size_t foci = 1;        ///< at the same time, as far as the board and the line can
    std::uint32_t periods = 10;  ///< of the carrier between two looks at a path, as far as the line can
};

/// Plays paths on a board that computes foci: where each path is now goes to the board, 8 bytes a focus, a few
/// milliseconds before it plays. So a new path begins at once, at the share of its pass at which the last one stopped.
/// Foci of a step that are more than a record of the board holds play in turn.
class FocusPlayer final : public Player {
public:
    /// Uploads the array's geometry in an image of foci, in place of what the board holds.
    /// @param line   to the board
    /// @param parts  of the device, each with the elements of its own; none: it is one board
    /// @throws Error{bad_input} as focus_image_of() does
    FocusPlayer(link::Commands& device, link::Clock& clock, const Array& array, const FocusPace& wanted,
                const Line& line, std::uint16_t watchdog_ms = 500, const std::vector<DevicePart>& parts = {});

    /// @param path  without a modulation
    void replace(const Path& path, std::uint64_t shot, double shot_s) override;
    void silence() override;
    void fade() override;
    bool service() override;
    /// Later than two frames to the board take.
    [[nodiscard]] bool sending() const override { return path_ && !begun_ && clock_.now_s() > late_s_; }
    [[nodiscard]] bool playing() const override { return path_.has_value(); }
    [[nodiscard]] bool fading() const override { return faded_s_.has_value(); }
    /// The pace that the line can carry.
    [[nodiscard]] FocusPace pace() const { return {ring_.each, dwell_}; }

private:
    void choose_pace(const FocusPace& wanted, const Line& line);
    void upload(const DevicePart& part, const Array& array);
    [[nodiscard]] std::vector<FocusWords> next_words();
    [[nodiscard]] const PathStep& step_now() const;
    void send(std::size_t count);

    std::uint32_t dwell_ = 0;    ///< carrier periods of a record
    std::size_t frame_ = 1;      ///< records of a frame on the line
    double lead_s_ = 0.0;        ///< that the board has in hand
    link::FocusRing ring_;       ///< its `each` is what a record holds
    std::uint64_t records_ = 0;  ///< that went into the ring
    std::optional<Path> path_;
    std::vector<double> ends_;  ///< of its steps, in periods
    double at_ = 0.0;           ///< in the pass, in periods
    std::size_t turn_ = 0;      ///< whose turn it is of foci that do not fit a record
    FocusWords last_{};         ///< where the focus was last
    SentRing about_;
    bool begun_ = false;             ///< a record of the path was pushed
    double late_s_ = 0.0;            ///< when that should have been
    std::optional<double> faded_s_;  ///< for so long what plays fades
    double asked_s_ = 0.0;           ///< when the device was asked for its status last
    std::optional<std::uint16_t> underruns_;
};

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
