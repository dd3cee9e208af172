// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// Keeps a board's carrier cycles in step with other boards' over the wire SYNC, and numbers them as those do
/// (rtl/README.md, contract 11). Registers that no reset touches begin with zeros.
class CarrierSync {
public:
    using Role = interface::Role;

    /// @param period_clocks  of a carrier period
    explicit CarrierSync(Clock period_clocks);

    /// Resets in this clock, as until `last`; the role holds from this clock on.
    void reset(Clock clock, Clock last, Role role);
    /// The wire has this level from this clock on.
    void wire(Clock clock, bool level);
    /// Told of each change of the wire by a master, with the clock after which it is seen.
    void on_change(std::function<void(Clock, bool level)> callback) { on_change_ = std::move(callback); }

    // As they are found in a clock, before step().
    [[nodiscard]] Role role() const { return role_; }
    [[nodiscard]] bool together() const { return role_ != Role::alone; }
    [[nodiscard]] bool in_step() const { return in_step_; }
    [[nodiscard]] bool out_of_step() const { return role_ == Role::slave && !in_step_; }
    [[nodiscard]] bool numbered(Clock clock) const;
    /// Level of the wire, of a master, after the last clock.
    [[nodiscard]] bool driven() const { return driven_; }

    /// The next clock in which something happens between the ends of cycles.
    [[nodiscard]] Clock next() const;
    struct Step {
        bool holds = false;                 ///< the last clock of the cycle is repeated
        bool ends = false;                  ///< the cycle ends with this clock
        bool missed = false, lost = false;  ///< to be counted
        std::optional<std::uint64_t> load;  ///< the number of the period that ends
    };
    /// What happens in this clock.
    /// @param last   whether it is the last one of a cycle, unless it is repeated
    /// @param count  the number of the present period, as this clock finds it
    Step step(Clock clock, bool last, std::uint64_t count);

private:
    /// The board's synchronizer shows the wire's level two clocks later, and a low one after a reset.
    [[nodiscard]] bool level(Clock clock) const;
    [[nodiscard]] Clock since(Clock clock) const;
    [[nodiscard]] bool rises(Clock clock) const;
    [[nodiscard]] bool waits(Clock clock) const;
    [[nodiscard]] Clock master_rise() const;
    void end_cycle(Clock clock, Step& step, std::uint64_t count);
    void take_symbol(std::optional<std::uint64_t>& load, std::uint64_t count);
    void sample_symbol(Clock before);
    void drive(Clock clock, bool level);

    Clock period_clocks_;
    Role role_ = Role::alone;
    Clock reset_ = 0;  // its last clock
    // The wire, of a slave.
    struct Change {
        Clock clock;
        bool level;
    };
    std::deque<Change> changes_;
    std::deque<Clock> looks_;    // when the level may have risen
    std::optional<Clock> edge_;  // the last one; of a master, its own
    unsigned symbol_ = 3;
    std::size_t sampled_ = 3;  // of the places in which the wire may have fallen since the edge
    // The wire, of a master.
    bool driven_ = false;
    Clock rise_at_ = never, fall_at_ = never;
    std::function<void(Clock, bool)> on_change_;
    // The cycle.
    Clock ended_ = 0;  // the last clock of the one before
    unsigned waited_ = 0;
    bool turn_ = false;
    unsigned part_ = 0, rate_ = 0;
    // In step or not.
    bool in_step_ = false;
    Clock lost_at_ = 0;
    unsigned cycles_ = 0, waits_ = 0, misses_ = 0;
    // The number.
    bool within_ = false, agreed_ = false, odd_ = false;
    unsigned place_ = 0;
    std::uint64_t upper_ = 0;
};

}  // namespace haptogram::sim
