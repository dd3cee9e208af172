// SPDX-License-Identifier: Apache-2.0
#include "reference_cycle.hpp"

#include <algorithm>
#include <utility>

namespace haptogram::sim {
namespace {

constexpr Clock pin_clocks = 2;  // from the tick behind it to the pins

bool tame(const Firing& firing, std::uint32_t cycle_length) {
    return 2 * firing.pulse <= cycle_length && cycle_length >= 5;
}

}  // namespace

CarrierCycle::CarrierCycle(const interface::CoreParameters& p, PulseTrain& train)
    : idle_clocks_(carrier_period(p)), guard_window_(p.max_high_clocks / 2 - 1), train_(train) {}

void CarrierCycle::reset(Clock clock) {
    settled_ = clock + 1;
    change_ = never;
    late_ = false;
    lengths_ = {idle_clocks_, 1};
    firing_.reset();
    index_ = dwell_ = 0;
    mark_ = pass_ = false;
    first_ticks_.clear();
    train_.stop(clock);
    begin(clock, true, 0);
}

CarrierCycle::End CarrierCycle::look(Clock clock, bool waits, bool hold, bool ready) const {
    End end;
    end.ready = ready && settled(clock);
    end.follows = follows(clock);
    const bool at_once = !waits && asked(clock) && end.ready;  // nothing has to complete while outputs are off
    end.held = last(clock) && hold && !at_once;
    end.ends = (last(clock) && !end.held) || at_once;
    return end;
}

Clock CarrierCycle::next(bool waits, Clock ready) const {
    Clock found = end_;
    if (ready != never && !waits && change_ != never) found = std::min(found, std::max({change_, ready, settled_}));
    if (!first_ticks_.empty()) found = std::min(found, first_ticks_.front().next + pin_clocks);
    return found;
}

/// The cycle's last tick becomes a clock longer.
void CarrierCycle::hold(Clock clock) {
    ++end_;
    if (settled_ > clock) ++settled_;
    if (lengths_.cycle == 1) ++first_ticks_.back().next;
}

void CarrierCycle::commit(Clock clock, const EntrySource::Entry& entry, std::optional<Lengths> lengths,
                          std::shared_ptr<Firing> firing) {
    const std::uint32_t old_pulse = pulse(), rest = this->rest();
    firing_ = std::move(firing);
    lengths_ = lengths.value_or(lengths_);
    index_ = entry.index;
    dwell_ = entry.dwell;
    mark_ = entry.mark;
    pass_ = entry.pass;
    change_ = never;
    late_ = false;
    settle_later(clock, rest);
    begin(clock, true, old_pulse);
}

bool CarrierCycle::go_on(Clock clock, bool ready) {
    const bool misses = dwell_ == 1 && !ready && !asked(clock) && !late_;
    late_ = late_ || misses;
    if (dwell_ > 1) --dwell_;
    begin(clock, false, 0);
    return misses;
}

bool CarrierCycle::go_on(Clock clock, bool ready, std::shared_ptr<Firing> firing) {
    const bool misses = dwell_ == 1 && !ready && !asked(clock) && !late_;
    late_ = late_ || misses;
    if (dwell_ > 1) --dwell_;
    const std::uint32_t old_pulse = pulse(), rest = this->rest();
    firing_ = std::move(firing);
    settle_later(clock, rest);
    begin(clock, true, old_pulse);
    return misses;
}

void CarrierCycle::settle_later(Clock clock, std::uint32_t rest) {
    settled_ = clock + 1 + (rest == 0 ? 0 : Clock{rest - 1} * lengths_.prescaler);
}

void CarrierCycle::begin(Clock clock, bool changed, std::uint32_t old_pulse) {
    begun_ = clock;
    end_ = clock + Clock{lengths_.cycle} * lengths_.prescaler;
    train_.begin_cycle(clock, lengths_.cycle, lengths_.prescaler, firing_, changed, old_pulse);
    if (!first_ticks_.empty()) first_ticks_.back().next = std::min(first_ticks_.back().next, clock);
    first_ticks_.push_back({clock + lengths_.prescaler, index_, mark_, pass_});
    mark_ = pass_ = false;  // those of the entry's first cycle
    if (!firing_ && old_pulse == 0) return;
    // Pulses of at most half of equal cycles merge to less than four pulses, which the guard's window is longer than.
    // What is left of a pulse from before a change lasts as many ticks as it would have, and these may be longer now.
    const bool same = lengths_.cycle == merged_.cycle && lengths_.prescaler == merged_.prescaler;
    if (!same || (firing_ && !tame(*firing_, lengths_.cycle)))
        may_merge_to_ = std::max({may_merge_to_, end_, settled_}) + 3 * guard_window_;
    if (firing_) merged_ = lengths_;
}

std::optional<PinStart> CarrierCycle::starts_at_pins(Clock clock) {
    if (first_ticks_.empty() || first_ticks_.front().next + pin_clocks != clock) return {};
    const Tick& tick = first_ticks_.front();
    const PinStart start{clock, tick.index, tick.mark, tick.pass};
    first_ticks_.pop_front();
    return start;
}

}  // namespace haptogram::sim
