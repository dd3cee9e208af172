// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"
#include "reference_pulses.hpp"
#include "reference_source.hpp"

namespace haptogram::sim {

/// A cycle begins at the pins.
struct PinStart {
    Clock clock;
    std::uint16_t index;
    bool mark, pass;
};

/// Counts the carrier cycles of the present record and says what becomes of each at its end; hands them to the pulse
/// train (rtl/cycle_controller.v and rtl/time/beside_pins.v).
class CarrierCycle {
public:
    CarrierCycle(const interface::CoreParameters& p, PulseTrain& train);

    void reset(Clock clock);

    /// What a clock finds, and what it means.
    struct End {
        bool held = false;     ///< the cycle's last clock is repeated
        bool ends = false;     ///< the cycle ends with this clock
        bool ready = false;    ///< the next record can be played
        bool follows = false;  ///< it is wanted
        [[nodiscard]] bool commits() const { return ends && ready && follows; }
    };
    /// @param waits  whether changes wait for the end of a cycle, as while pulses may reach the pins
    /// @param hold   the cycle does not end in this clock
    /// @param ready  whether the next record is there
    [[nodiscard]] End look(Clock clock, bool waits, bool hold, bool ready) const;
    [[nodiscard]] bool last(Clock clock) const { return clock >= end_; }
    /// Whether the next record is wanted at the end of this cycle, and whether a change was asked for.
    [[nodiscard]] bool follows(Clock clock) const { return dwell_ <= 1 || asked(clock); }
    [[nodiscard]] bool asked(Clock clock) const { return change_ <= clock; }
    /// Whether every pulse from before the last change has ended in this clock.
    [[nodiscard]] bool settled(Clock clock) const { return settled_ <= clock; }
    [[nodiscard]] Clock settled_from() const { return settled_; }

    // What follows from it, in the order of the clock.
    void hold(Clock clock);
    struct Lengths {
        std::uint32_t cycle, prescaler;
    };
    /// @param lengths  none for silence, which keeps those that are there
    /// @param firing   none when it has no pulses
    void commit(Clock clock, const EntrySource::Entry& entry, std::optional<Lengths> lengths,
                std::shared_ptr<Firing> firing);
    /// The record goes on for a cycle, with the pulses it has, or with others.
    /// @return whether a change was due that did not come
    bool go_on(Clock clock, bool ready);
    bool go_on(Clock clock, bool ready, std::shared_ptr<Firing> firing);
    /// A change is asked for, whatever is left of the dwell.
    void ask(Clock clock) { change_ = clock + 1; }
    /// What this cycle's end puts to use is there from this clock on; or is not wanted any more.
    void prepare(Clock clock, std::uint32_t cycle, std::shared_ptr<Firing> firing) {
        train_.prepare(clock, cycle, std::move(firing));
    }
    void drop() { train_.drop(); }
    /// Outputs are off, so no pulse is under way.
    void settle(Clock clock) { settled_ = std::min(settled_, clock + 1); }

    [[nodiscard]] Clock begun() const { return begun_; }
    [[nodiscard]] std::uint32_t prescaler() const { return lengths_.prescaler; }
    /// The clock in which something happens next; with `ready` from that clock on, a change that was asked for.
    [[nodiscard]] Clock next(bool waits, Clock ready) const;

    /// A cycle begins at the pins in this clock; called before the pulses of this clock are made.
    [[nodiscard]] std::optional<PinStart> starts_at_pins(Clock clock);
    /// Until this clock some pin may be high for as long as the guard's window, unless a record comes that is worse.
    [[nodiscard]] Clock may_merge_to() const { return may_merge_to_; }

private:
    void begin(Clock clock, bool changed, std::uint32_t old_pulse);
    [[nodiscard]] std::uint32_t pulse() const { return firing_ ? firing_->pulse : 0; }
    void settle_later(Clock clock, std::uint32_t rest);
    [[nodiscard]] std::uint32_t rest() const { return firing_ ? firing_->rest() : 0; }

    std::uint32_t idle_clocks_;
    Clock guard_window_;
    PulseTrain& train_;

    Clock begun_ = 0, end_ = 0;  // the last clocks of the cycle before and of this one
    Lengths lengths_{0, 1};
    std::shared_ptr<Firing> firing_;
    std::uint16_t index_ = 0, dwell_ = 0;
    bool mark_ = false, pass_ = false;  // of this cycle
    Clock change_ = never;              // from which clock on a change is asked for
    Clock settled_ = 0;
    bool late_ = false;  // the change that is due has been missed
    Clock may_merge_to_ = 0;
    Lengths merged_{0, 0};  // of the last cycle with pulses
    struct Tick {
        Clock next;  // when the tick behind it begins
        std::uint16_t index;
        bool mark, pass;
    };
    std::deque<Tick> first_ticks_;  // of cycles that have not begun at the pins
};

}  // namespace haptogram::sim
