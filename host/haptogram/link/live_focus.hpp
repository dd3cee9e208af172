// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>

#include "haptogram/format/path.hpp"
#include "haptogram/link/play.hpp"

namespace haptogram::link {

/// The focus that is wanted now. Whoever moves it never waits: it is one word, and the newest wins.
class FocusMailbox {
public:
    explicit FocusMailbox(const Clock& clock) : clock_(clock) {}

    /// @throws Error{bad_input} as pack_focus() does; then the mailbox is empty: the earlier focus is out of date
    void put(const Focus& focus);
    void clear() { words_ = 0; }
    /// @param most_age  the focus is silent if the newest one is older than this; 0: never
    [[nodiscard]] std::uint64_t newest(std::chrono::milliseconds most_age) const;

private:
    const Clock& clock_;
    std::atomic<std::uint64_t> words_ = 0;  ///< FocusWords; at first amplitude 0
    std::atomic<Clock::Time::rep> put_at_ = 0;
};

struct LiveFocusSettings {
    std::uint16_t watchdog_ms = 500;        ///< outputs go off when this host is silent for so long; 0: never
    std::chrono::milliseconds most_age{0};  ///< of a focus; a program that hangs moves it no more. 0: it stays
    double step_s = 0.2e-3;                 ///< for so long a focus stays before a newer one can follow, at first
    double lead_s = 0.6e-3;                 ///< what the board has in hand at first
    double most_lead_s = 50e-3;             ///< while the board runs dry, the lead grows up to this, and then the step
};

/// What goes on while a focus is live.
struct LiveFocusPlaying {
    std::uint64_t sent = 0;  ///< foci
    double step_s = 0.0, lead_s = 0.0;
    Status status;
};

/// Turns the outputs on and plays the newest focus of the mailbox until the watch ends it; then off again. The board's
/// own clock sets the pace: only as much is sent as it has played.
/// @param watch  told between any two frames; false ends it
/// @throws Error{device} as make_ring() does, or when the board turns its outputs off by itself
Played play_live_focus(Commands& device, const LiveFocusSettings& settings, const FocusMailbox& mailbox,
                       const std::function<bool(const LiveFocusPlaying&)>& watch);

}  // namespace haptogram::link
