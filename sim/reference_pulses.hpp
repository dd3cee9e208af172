// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "clock.hpp"

namespace haptogram::sim {

/// The pulses of a cycle: when each channel rises, and for how long it is high.
struct Firing {
    struct Rise {
        std::uint32_t tick, channel, ticks;
    };
    static constexpr std::uint32_t silent = ~0U;

    explicit Firing(std::uint32_t channels) : tick(channels, silent), ahead_tick(channels, silent) {
        rises.reserve(channels);
    }
    /// A channel's pulse begins in this tick of the cycle and lasts for `ticks` ticks, also into the next cycle.
    void add(std::uint32_t channel, std::uint32_t at, std::uint32_t ticks) {
        tick[channel] = at;
        rises.push_back({at, channel, ticks});
        pulse = std::max(pulse, ticks);
    }
    /// The same of a pulse that ends in the next cycle, to which its middle belongs. So it begins in the cycle before
    /// the firing's first one, if that knows of it in time. In each of the firing's cycles the channel is high up to
    /// `end`.
    void add_early(std::uint32_t channel, std::uint32_t at, std::uint32_t ticks, std::uint32_t end) {
        add(channel, 0, end);
        ahead_tick[channel] = at;
        ahead.push_back({at, channel, ticks});
        pulse = std::max(pulse, ticks);
    }
    /// Brings them in order; needed only when somebody looks at the pulses, and done once.
    void sort() {
        if (std::exchange(sorted_, true)) return;
        const auto before = [](const Rise& a, const Rise& b) {
            return a.tick != b.tick ? a.tick < b.tick : a.channel < b.channel;
        };
        std::ranges::sort(rises, before);
        std::ranges::sort(ahead, before);
    }
    /// Behind a cycle's end, the tick with which the last of its pulses has ended, counted from 1.
    [[nodiscard]] std::uint32_t rest() const { return centred ? pulse / 2 + 1 : pulse; }

    std::uint32_t pulse = 0;                ///< ticks of the longest
    bool centred = false;                   ///< each pulse is centred on a phase of its cycle
    std::vector<Rise> rises;                ///< by tick and then by channel
    std::vector<Rise> ahead;                ///< those that begin in the cycle before
    std::vector<std::uint32_t> tick;        ///< of each channel; `silent` when it has no pulse
    std::vector<std::uint32_t> ahead_tick;  ///< in the cycle before; `silent` when it does not begin there

private:
    bool sorted_ = false;
};

/// The pulses at the pins, from the cycles that are played (rtl/README.md, contract 1).
///
/// Ticks are counted from the first cycle on. A channel's pulse is high in the ticks from its timing on, as many as the
/// record says; pulses that overlap merge. A pin shows a tick's state from two clocks after the beginning of the tick
/// behind it. So the change in a cycle's last tick may depend on the next cycle, and everything is computed as late as
/// it is asked for.
class PulseTrain {
public:
    /// Where a gap of one tick between two pulses is filled: at changes of record (pulse_generators.v), or everywhere
    /// (width_pulse_generators.v).
    enum class Gaps { at_changes, all };

    /// @param history  clocks; cycles that ended longer ago are forgotten while nobody asks for pulses
    PulseTrain(std::uint32_t channels, Gaps gaps, Clock history)
        : history_(history), gaps_(gaps), pulses_(channels), high_since_(channels), pins_((channels + 31) / 32) {}

    /// Told of each change of a pin, in the order of clocks, and of channels within a clock.
    void on_change(std::function<void(Clock, std::uint32_t channel, bool rises)> callback) {
        on_change_ = std::move(callback);
    }

    /// A cycle begins; the one before it ends there, even if it had ticks left, which happens only while stopped, or if
    /// its last tick became longer.
    /// @param firing     none when it is silent; kept until the cycle's pulses have ended
    /// @param changed    the firing is put to use with it, instead of one with pulses of `old_pulse` ticks
    void begin_cycle(Clock begin, std::uint32_t ticks, std::uint32_t prescaler, std::shared_ptr<Firing> firing,
                     bool changed, std::uint32_t old_pulse);
    /// The end of the present cycle will put a firing to use, whose cycle has so many ticks. In ticks that begin a
    /// pulse in clock `from` or later its early ones may begin.
    void prepare(Clock from, std::uint32_t ticks, std::shared_ptr<Firing> firing);
    /// It will not.
    void drop() { cycles_.back().next.reset(); }
    /// All pins are low from this clock on, and no pulse begins until resume().
    void stop(Clock clock);
    /// Pulses whose tick began two clocks before this one, or later, reach the pins again.
    void resume(Clock clock);
    /// Pulses are wanted, from clock `last` + 1 on; the state at `last` is found from what is still known.
    void wake(Clock last);
    /// Nobody wants pulses any more: cycles are noted, and nothing is computed.
    void sleep() { awake_ = false; }
    [[nodiscard]] bool awake() const { return awake_; }

    /// Makes every change up to and with this clock.
    void advance(Clock last);
    /// Whether some pin is high, and has been so since this clock or longer.
    [[nodiscard]] bool any_high_since(Clock clock) const;
    [[nodiscard]] const std::vector<std::uint32_t>& pins() const { return pins_; }

private:
    struct Cycle {
        Clock begin;
        std::uint64_t first;  // number of its tick 0
        std::uint32_t ticks, prescaler;
        std::shared_ptr<Firing> firing;
        bool changed;
        std::uint64_t filled_to;  // up to this tick, a gap of one tick between pulses is filled
        std::uint32_t length;     // ticks, were it not cut
        bool stretched = false;   // its last tick is longer
        struct Next {
            Clock from;
            std::uint32_t ticks;
            std::shared_ptr<Firing> firing;
        };
        std::optional<Next> next = {};  // what waits for its end
        [[nodiscard]] bool knows_next(std::uint64_t tick) const;
        [[nodiscard]] std::uint64_t ahead(const Firing::Rise& rise) const;
        [[nodiscard]] bool begins(std::uint32_t channel, std::uint64_t tick) const;
    };
    struct Fall {
        std::uint64_t tick;
        std::uint32_t channel;
    };
    /// A queue by ticks and channels, whose storage is used again.
    class Falls {
    public:
        [[nodiscard]] bool empty() const { return head_ == falls_.size(); }
        [[nodiscard]] const Fall& front() const { return falls_[head_]; }
        void push(const Fall& fall) {
            auto at = falls_.end();
            while (at != begin() && before(fall, *(at - 1))) --at;
            falls_.insert(at, fall);
        }
        void pop() {
            if (++head_ == falls_.size()) clear();
        }
        void clear() { falls_.clear(), head_ = 0; }
        void swap(Falls& other) { falls_.swap(other.falls_), std::swap(head_, other.head_); }

    private:
        [[nodiscard]] std::vector<Fall>::iterator begin() {
            return falls_.begin() + static_cast<std::ptrdiff_t>(head_);
        }
        [[nodiscard]] static bool before(const Fall& a, const Fall& b) {
            return a.tick != b.tick ? a.tick < b.tick : a.channel < b.channel;
        }

        std::vector<Fall> falls_;
        std::size_t head_ = 0;
    };

    void forget_before(Clock clock);
    void leave_cycle();
    void rise(Clock clock, std::uint64_t tick, const Firing::Rise& rise);
    void fall(Clock clock, std::uint64_t tick, std::uint32_t channel);
    [[nodiscard]] bool fills(std::uint64_t tick, std::uint32_t channel) const;
    void set(Clock clock, std::uint32_t channel, bool level);
    [[nodiscard]] bool is_high(std::uint32_t channel) const { return (pins_[channel / 32] >> channel % 32 & 1U) != 0; }

    Clock history_;
    Gaps gaps_;
    std::deque<Cycle> cycles_;          // those whose changes have not all been made
    std::size_t next_rise_ = 0;         // in the first of them
    std::size_t next_ahead_ = 0;        // of those of the firing that waits for its end
    Falls old_falls_, new_falls_;       // of pulses from before the last change of record, and from after it
    std::vector<std::uint8_t> pulses_;  // how many each channel is in
    std::vector<Clock> high_since_;
    std::vector<std::uint32_t> pins_;
    Clock alive_from_ = never;
    bool awake_ = false;
    bool quiet_ = false;  // while the state is found again, observers are not told
    std::function<void(Clock, std::uint32_t, bool)> on_change_;
};

}  // namespace haptogram::sim
