// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/focus_engine.hpp"
#include "haptogram/link/focus_ring.hpp"
#include "haptogram/live/player.hpp"

namespace haptogram::live {

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
    /// What the line leaves of what was wanted.
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

}  // namespace haptogram::live
