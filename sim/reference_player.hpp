// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "clock.hpp"
#include "haptogram/boards/interface.hpp"
#include "reference_pulses.hpp"
#include "reference_source.hpp"

namespace haptogram::sim {

/// Loads records and commits them at the ends of cycles (rtl/README.md, contracts 2, 3 and 7); hands each cycle to the
/// pulse train. A stage between a record and its pulses belongs into load().
class Player {
public:
    Player(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary, EntrySource& source,
           PulseTrain& train);

    void reset(Clock clock);

    /// Whether a word of primary memory, or any, is being read in this clock.
    [[nodiscard]] bool reads(Clock clock, std::uint32_t word) const;
    [[nodiscard]] bool reads(Clock clock) const;
    /// The last clock in which the record that is being loaded is read, unless it is dropped before.
    [[nodiscard]] Clock reads_to() const;
    /// A word of primary memory is written in this clock; to be called before its value changes.
    void written(Clock clock, std::uint32_t word, std::uint16_t value);

    /// @param waits  whether changes wait for the end of a cycle, as while pulses may reach the pins
    [[nodiscard]] Clock next(bool waits) const;
    /// Whether this is the last clock of a cycle, unless it is repeated.
    [[nodiscard]] bool last(Clock clock) const { return clock >= end_; }
    // What happens in a clock, in this order.
    struct Counted {
        bool refused = false, underrun = false;
    };
    /// @param hold    the cycle does not end in this clock; its last one is repeated
    /// @param common  cycles have one length, a carrier period's; other records are refused
    void at(Clock clock, bool waits, bool off, bool hold, bool common, Counted& counted);

    struct PinStart {
        Clock clock;
        std::uint16_t index;
    };
    /// A cycle begins at the pins in this clock; called before the pulses of this clock are made.
    [[nodiscard]] std::optional<PinStart> starts_at_pins(Clock clock);

    /// Whether a pulse from before the last commit may still run in this clock.
    [[nodiscard]] bool unsettled(Clock clock) const { return settled_ > clock; }
    /// Until this clock some pin may be high for as long as the guard's window, unless a record comes that is worse.
    [[nodiscard]] Clock may_merge_to() const { return may_merge_to_; }

private:
    /// A record as it was found in memory.
    struct Loaded {
        std::vector<std::uint16_t> words;
        std::uint32_t cycle_length = 0, prescaler = 0;
        bool playable = false;
        bool common = false;                   // its cycle is a carrier period
        std::shared_ptr<const Firing> firing;  // none without pulses
    };
    struct Load {
        Clock taken = 0, ready = 0;
        EntrySource::Entry entry;
        std::uint32_t first = 0;                         // word of primary memory
        std::optional<std::vector<std::uint16_t>> seen;  // when the record was written while it was read
        std::shared_ptr<const Loaded> record;            // none for silence
        bool done = false;
    };

    [[nodiscard]] bool from_memory(const Load& load) const {
        return load.entry.index > 0 && load.entry.index <= records_;
    }
    void take(Clock clock);
    void finish_load(bool common, Counted& counted);
    [[nodiscard]] std::shared_ptr<const Loaded> load(std::span<const std::uint16_t> words, std::size_t index);
    [[nodiscard]] bool is_ready(Clock clock) const { return load_ && load_->ready <= clock && settled_ <= clock; }
    [[nodiscard]] Clock take_at() const;
    bool boundary(Clock clock, bool waits, bool hold, Counted& counted);
    void hold(Clock clock);
    void commit(Clock clock);
    void begin_cycle(Clock clock, bool committed, std::uint32_t old_pulse);

    interface::CoreParameters p_;
    std::uint32_t records_, record_words_;
    Clock guard_window_;
    const std::vector<std::uint16_t>& primary_;
    EntrySource& source_;
    PulseTrain& train_;
    std::vector<std::shared_ptr<const Loaded>> known_;  // by index; used again while memory holds the same words

    std::optional<Load> load_;
    Clock idle_ = 0;        // from which clock on an entry can be taken
    Clock settled_ = 0;     // from which clock on every pulse from before the last commit has ended
    Clock change_ = never;  // from which clock on a change is asked for, whatever is left of the dwell
    bool late_ = false;
    // The present record.
    Clock end_ = 0;  // the last clock of its cycle
    std::uint32_t cycle_length_ = 0, prescaler_ = 1, pulse_ = 0;
    std::shared_ptr<const Firing> firing_;
    std::uint16_t index_ = 0, dwell_ = 0;
    Clock may_merge_to_ = 0;
    std::uint32_t merge_cycle_ = 0, merge_prescaler_ = 0;  // of the last record with pulses
    struct Tick {
        Clock next;  // when the tick behind it begins
        std::uint16_t index;
    };
    std::deque<Tick> first_ticks_;  // of cycles that have not begun at the pins
};

}  // namespace haptogram::sim
