// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// Whether pulses may reach the pins, and the watchdog (rtl/README.md, contract 4).
class Guard {
public:
    explicit Guard(const interface::CoreParameters& p)
        : clocks_per_ms_(p.clock_hz / 1000), default_ms_(static_cast<std::uint16_t>(p.watchdog_ms)) {}

    /// A command begins the watchdog's time anew, and may set it.
    void kick(Clock clock) { expiry_ = enabled_ ? expiry_after(clock) : never; }
    void set_watchdog(Clock clock, std::uint16_t milliseconds) {
        watchdog_ms_ = milliseconds;
        kick(clock);
    }
    void trip_at(Clock clock) { trips_at_ = clock; }
    void wake_at(Clock clock) { wakes_at_ = std::min(wakes_at_, clock); }
    void reset() {
        enabled_ = allow_ = pulsed_ = fault_ = false;
        off_ = true;
        watchdog_ms_ = default_ms_;
        expiry_ = expires_at_ = trips_at_ = wakes_at_ = never;
    }

    [[nodiscard]] Clock next() const { return std::min({wakes_at_, expiry_, expires_at_, trips_at_}); }
    struct Verdict {
        bool expired, tripped;  ///< to be counted
    };
    /// @param enable, disable  what commands, the line, the stop input and SYNC want in this clock
    /// @param lost             the board falls out of step with others
    /// @param mute             no pulse may reach the pins, which changes nothing else
    Verdict at(Clock clock, bool enable, bool disable, bool lost, bool mute) {
        if (clock == expiry_) {
            expires_at_ = clock + 1;
            expiry_ = never;
        }
        const bool expired = clock == expires_at_;
        const bool tripped = clock == trips_at_;
        if (expired) expires_at_ = never;
        if (tripped) trips_at_ = never;
        if (clock >= wakes_at_) wakes_at_ = never;

        const bool allow = enabled_ && !disable && !expired && !tripped;
        const bool pulses = allow && !mute;
        const bool off = !pulses || !pulsed_;  // a clock more, so that the first pulse is whole
        const bool enabled = !disable && !tripped && !expired && (enable || enabled_);
        if (allow != allow_ || pulses != pulsed_ || off != off_ || enabled != enabled_) wakes_at_ = clock + 1;
        if (tripped || expired || (lost && enabled_))
            fault_ = true;
        else if (enable)
            fault_ = false;
        allow_ = allow;
        pulsed_ = pulses;
        off_ = off;
        enabled_ = enabled;
        if (!enabled) expiry_ = never;
        if (enabled && enable) expiry_ = expiry_after(clock);
        return {expired, tripped};
    }

    /// Whether the watchdog or the guard acts in this clock.
    [[nodiscard]] bool acts(Clock clock) const { return clock == expires_at_ || clock == trips_at_; }

    /// After at(): whether pulses may be played in this clock, and reach the pins, and whether the pins' registers are
    /// cleared by it.
    [[nodiscard]] bool allows() const { return allow_; }
    [[nodiscard]] bool pulses() const { return pulsed_; }
    [[nodiscard]] bool off() const { return off_; }
    /// As the next clock finds them.
    [[nodiscard]] bool enabled() const { return enabled_; }
    [[nodiscard]] bool fault() const { return fault_; }
    [[nodiscard]] std::uint16_t watchdog_ms() const { return watchdog_ms_; }

private:
    [[nodiscard]] Clock expiry_after(Clock clock) const {
        return watchdog_ms_ == 0 ? never : clock + watchdog_ms_ * clocks_per_ms_;
    }

    Clock clocks_per_ms_;
    std::uint16_t default_ms_, watchdog_ms_ = 0;
    bool enabled_ = false, allow_ = false, pulsed_ = false, off_ = true, fault_ = false;
    Clock expiry_ = never, expires_at_ = never, trips_at_ = never, wakes_at_ = never;
};

}  // namespace haptogram::sim
