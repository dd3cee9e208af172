// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "clock.hpp"

namespace haptogram::sim {

/// Counts the carrier periods at the pins, and keeps what waits for one of them (rtl/README.md, contract 10).
class Schedule {
public:
    using Arguments = std::array<std::uint16_t, 3>;

    void reset() {
        const bool has = has_trigger;
        *this = {};
        has_trigger = has;
    }

    /// A period begins at the pins in this clock.
    void period_begins(Clock clock) {
        ++count_;
        begun_ = {clock, begun_[0], begun_[1]};
    }
    /// The period that ends in this clock, and is followed by another one, has this number.
    void load(Clock clock, std::uint64_t number) {
        loaded_ = Loaded{clock, count_, begun_};
        count_ = number;
    }
    /// As a reply tells it that begins in this clock.
    [[nodiscard]] std::uint64_t period(Clock clock) const { return counted(clock, count_clocks); }
    [[nodiscard]] bool waiting() const { return start_ || follows_ || pushed_ || modulates_; }

    // The gate.
    void gate(std::uint64_t period) {
        if (period != 0 && period != at_end) gate_ = period;
        armed_ = period != 0;
        at_end_ = period == at_end;
    }
    [[nodiscard]] bool busy(std::uint64_t period) const {
        return waits_for_period() && period != gate_ && period != 0 && period != at_end;
    }
    [[nodiscard]] bool for_the_end() const { return armed_ && at_end_; }
    /// The gate is for what comes at the trigger input; of boards that have one.
    [[nodiscard]] bool by_trigger() const { return has_trigger && gate_ == at_trigger; }
    [[nodiscard]] bool takes_no_push() const { return armed_ && (at_end_ || by_trigger()); }
    /// Whether it comes in this clock.
    void trigger(bool comes) { trigger_ = comes; }
    static constexpr std::uint64_t at_end = (std::uint64_t{1} << 48) - 1, at_trigger = at_end - 1;
    bool has_trigger = false;
    void forget() { armed_ = false; }

    /// What a command that uses the gate does in this clock.
    enum class Turn { now, waits, follows };
    struct Use {
        Turn turn;
        bool late;
    };
    [[nodiscard]] Use use(Clock clock) {
        const bool for_period = armed_ && !at_end_;
        const Turn turn = for_the_end() ? Turn::follows : for_period && !reached(clock) ? Turn::waits : Turn::now;
        armed_ = false;
        return {turn, for_period && turn == Turn::now && !by_trigger()};
    }

    // What waits.
    void start_waits(const Arguments& arguments) { start_ = arguments; }
    void start_follows() { follows_ = true; }
    void push_waits() { pushed_ = true; }
    void drop_starts() { start_.reset(), follows_ = false; }
    void drop_pushed() { pushed_ = false; }
    [[nodiscard]] bool push_is_waiting() const { return pushed_; }
    void modulation_waits(bool waits) { modulates_ = waits; }
    [[nodiscard]] bool take_modulation() { return std::exchange(modulates_, false); }

    /// Whether what waits for the period goes on in this clock.
    [[nodiscard]] bool opens(Clock clock) const { return waits_for_period() && reached(clock); }
    [[nodiscard]] std::optional<Arguments> take_start() {
        const std::optional<Arguments> start = start_;
        start_.reset();
        return start;
    }
    /// The clock in which it does, as far as is known.
    [[nodiscard]] Clock next() const {
        if (!waits_for_period() || by_trigger() || count_ + 1 < gate_) return never;
        return begun_[std::min<std::uint64_t>(count_ + 1 - gate_, begun_.size() - 1)] + compare_clocks;
    }

private:
    static constexpr Clock count_clocks = 2;    // from a period's beginning until it is counted
    static constexpr Clock compare_clocks = 3;  // and until its number is compared

    struct Loaded {
        Clock clock;
        std::uint64_t count;  // from before it
        std::array<Clock, 3> begun;
    };

    [[nodiscard]] bool waits_for_period() const { return start_ || pushed_ || modulates_; }
    /// Without those that began fewer than `delay` clocks ago. A number that is loaded is known a clock earlier.
    [[nodiscard]] std::uint64_t counted(Clock clock, Clock delay) const {
        const bool before = loaded_ && clock + 1 < loaded_->clock + delay;
        std::uint64_t known = before ? loaded_->count : count_;
        for (const Clock begun : before ? loaded_->begun : begun_)
            if (known > 0 && clock < begun + delay) --known;
        return known;
    }
    [[nodiscard]] bool reached(Clock clock) const {
        if (by_trigger()) return trigger_;
        return counted(clock, compare_clocks) + 1 >= gate_;
    }

    std::uint64_t count_ = 0;
    std::array<Clock, 3> begun_{};  // the last periods, the latest one first
    std::optional<Loaded> loaded_;
    std::uint64_t gate_ = 0;
    bool armed_ = false, at_end_ = false, trigger_ = false;
    std::optional<Arguments> start_;
    bool follows_ = false, pushed_ = false, modulates_ = false;
};

}  // namespace haptogram::sim
