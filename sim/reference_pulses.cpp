// SPDX-License-Identifier: Apache-2.0
#include "reference_pulses.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace haptogram::sim {
namespace {

constexpr Clock lateness = 2;  // clocks from the beginning of the next tick until a pin shows a tick's state

}  // namespace

void PulseTrain::begin_cycle(Clock begin, std::uint32_t ticks, std::uint32_t prescaler, std::shared_ptr<Firing> firing,
                             bool changed, std::uint32_t old_pulse) {
    Cycle cycle{begin, 0, ticks, prescaler, std::move(firing), changed, 0, ticks};
    if (!cycles_.empty()) {
        Cycle& before = cycles_.back();
        const Clock lasted = begin - before.begin;
        before.stretched = lasted > Clock{before.ticks} * before.prescaler;
        if (!before.stretched)
            before.ticks = static_cast<std::uint32_t>((lasted + before.prescaler - 1) / before.prescaler);
        cycle.first = before.first + before.ticks;
        cycle.filled_to = alive_from_ == never ? 0 : before.filled_to;
    }
    if (changed) cycle.filled_to = cycle.first + std::max(old_pulse, 1U);
    cycles_.push_back(std::move(cycle));
    if (!awake_) forget_before(alive_from_ == never ? begin : begin - std::min(begin, history_));
}

void PulseTrain::prepare(Clock from, std::uint32_t ticks, std::shared_ptr<Firing> firing) {
    if (firing) firing->sort();
    cycles_.back().next = {from, ticks, std::move(firing)};
}

/// Whether what waits says which early pulses begin in this tick: in the last quarter, if it is there in time.
bool PulseTrain::Cycle::knows_next(std::uint64_t tick) const {
    return next && prescaler == 1 && tick + length / 4 >= length && begin + tick + 1 >= next->from;
}

/// The tick of this cycle in which an early pulse of what waits begins; none is 0.
std::uint64_t PulseTrain::Cycle::ahead(const Firing::Rise& rise) const {
    const std::uint64_t tick = std::uint64_t{length} + rise.tick;
    return tick > next->ticks && knows_next(tick - next->ticks) ? tick - next->ticks : 0;
}

bool PulseTrain::Cycle::begins(std::uint32_t channel, std::uint64_t tick) const {
    if (firing && firing->tick[channel] == tick) return true;
    return next && next->firing && next->firing->ahead_tick[channel] != Firing::silent && tick != 0 &&
           ahead({next->firing->ahead_tick[channel], channel, 0}) == tick;
}

/// Two cycles are kept whatever their age: the last ticks of one may be under way when the next begins.
void PulseTrain::forget_before(Clock clock) {
    while (cycles_.size() > 2 && cycles_[1].begin <= clock) cycles_.pop_front();
}

void PulseTrain::stop(Clock clock) {
    if (awake_) advance(clock - 1);
    alive_from_ = never;
    for (Cycle& cycle : cycles_) cycle.filled_to = 0;
    old_falls_.clear();
    new_falls_.clear();
    std::ranges::fill(pulses_, std::uint8_t{0});
    if (!awake_) return;
    for (std::size_t word = 0; word < pins_.size(); ++word)
        while (pins_[word] != 0) {
            const auto bit = static_cast<std::uint32_t>(std::countr_zero(pins_[word]));
            set(clock, static_cast<std::uint32_t>(32 * word) + bit, false);
        }
}

/// A commit in the clock before is the only one while stopped whose gaps are still filled.
void PulseTrain::resume(Clock clock) {
    if (awake_) advance(clock - 1);
    alive_from_ = clock;
    for (Cycle& cycle : cycles_)
        if (cycle.begin + 1 < clock) cycle.filled_to = 0;
}

void PulseTrain::wake(Clock last) {
    if (awake_) return;
    awake_ = true;
    next_rise_ = next_ahead_ = 0;
    old_falls_.clear();
    new_falls_.clear();
    std::ranges::fill(pulses_, std::uint8_t{0});
    std::ranges::fill(pins_, 0U);
    quiet_ = true;
    advance(last);
    quiet_ = false;
}

void PulseTrain::advance(Clock last) {
    while (!cycles_.empty()) {
        const Cycle& cycle = cycles_.front();
        const std::uint64_t end = cycle.first + cycle.ticks;
        // The next change: of one tick, the lowest channel; of one channel, the rise.
        std::uint64_t tick = end;
        std::uint32_t channel = 0;
        Falls* falls = nullptr;
        const Firing::Rise* next = nullptr;
        if (cycle.firing) cycle.firing->sort();
        if (cycle.firing && next_rise_ < cycle.firing->rises.size()) {
            next = &cycle.firing->rises[next_rise_];
            if (cycle.first + next->tick < end) tick = cycle.first + next->tick, channel = next->channel;
        }
        const Firing::Rise* ahead = nullptr;
        if (cycle.next && cycle.next->firing && next_ahead_ < cycle.next->firing->ahead.size()) {
            const Firing::Rise& rise = cycle.next->firing->ahead[next_ahead_];
            const std::uint64_t at = cycle.first + cycle.ahead(rise);
            if (at == cycle.first) {
                ++next_ahead_;
                continue;
            }
            if (at < tick || (at == tick && tick < end && rise.channel < channel))
                tick = at, channel = rise.channel, ahead = &rise;
        }
        for (Falls* queue : {&old_falls_, &new_falls_}) {
            if (queue->empty()) continue;
            const Fall& fall = queue->front();
            if (fall.tick < tick || (fall.tick == tick && tick < end && fall.channel < channel))
                tick = fall.tick, channel = fall.channel, falls = queue;
        }
        if (tick >= end) {
            if (cycles_.size() == 1) return;
            leave_cycle();
            continue;
        }
        // When the last tick ends, the next cycle tells.
        const bool ends_cycle = tick + 1 == end;
        if (ends_cycle && cycles_.size() == 1) return;
        const Clock began = cycle.begin + (tick - cycle.first) * cycle.prescaler;
        const Clock clock = (ends_cycle ? cycles_[1].begin : began + cycle.prescaler) + lateness;
        if (clock > last) return;
        if (falls != nullptr) {
            falls->pop();
            fall(clock, tick, channel);
        } else if (ahead != nullptr) {
            ++next_ahead_;
            if (alive_from_ != never && began + lateness >= alive_from_) rise(clock, tick, *ahead);
        } else {
            ++next_rise_;
            if (alive_from_ != never && began + lateness >= alive_from_) rise(clock, tick, *next);
        }
    }
}

void PulseTrain::leave_cycle() {
    cycles_.pop_front();
    next_rise_ = next_ahead_ = 0;
    // A record is only committed when the pulses from before the last change have ended.
    if (cycles_.front().changed) old_falls_.swap(new_falls_);
}

void PulseTrain::rise(Clock clock, std::uint64_t tick, const Firing::Rise& rise) {
    new_falls_.push({tick + rise.ticks, rise.channel});
    if (pulses_[rise.channel]++ == 0 && !is_high(rise.channel)) set(clock, rise.channel, true);
}

void PulseTrain::fall(Clock clock, std::uint64_t tick, std::uint32_t channel) {
    if (--pulses_[channel] == 0 && !fills(tick + 1, channel)) set(clock, channel, false);
}

/// Whether a pulse that begins in this tick fills the gap of one tick before it: everywhere, or at a change of record,
/// as long as a pulse from before it can have ended just now.
bool PulseTrain::fills(std::uint64_t tick, std::uint32_t channel) const {
    const Cycle* cycle = &cycles_.front();
    const Cycle* next = cycles_.size() > 1 ? &cycles_[1] : nullptr;
    if (tick == cycle->first + cycle->ticks) {
        cycle = std::exchange(next, nullptr);
        if (cycle == nullptr) return false;
    }
    if (!cycle->begins(channel, tick - cycle->first)) return false;
    if (gaps_ == Gaps::all) return true;
    // With one clock a tick, the commit is known before the last tick's state has reached the pin.
    const bool before_commit =
        next != nullptr && next->changed && cycle->prescaler == 1 && !cycle->stretched && tick + 1 == next->first;
    return tick <= cycle->filled_to || before_commit;
}

void PulseTrain::set(Clock clock, std::uint32_t channel, bool level) {
    pins_[channel / 32] ^= 1U << channel % 32;
    if (level) high_since_[channel] = clock;
    if (on_change_ && !quiet_) on_change_(clock, channel, level);
}

bool PulseTrain::any_high_since(Clock clock) const {
    for (std::uint32_t channel = 0; channel < high_since_.size(); ++channel)
        if (is_high(channel) && high_since_[channel] <= clock) return true;
    return false;
}

}  // namespace haptogram::sim
