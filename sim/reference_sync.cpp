// SPDX-License-Identifier: Apache-2.0
#include "reference_sync.hpp"

#include <algorithm>
#include <bit>

namespace haptogram::sim {
namespace {

// rtl/time/carrier_sync.v says what these are.
constexpr Clock lead = 48, delay = 6, due = lead - delay;
constexpr Clock unheard = 127;  // clocks since an edge
constexpr Clock most_clock = 2047;
constexpr unsigned most_waits = 8, cycles_to_step = 512, misses_to_loss = 16;
constexpr unsigned parts_of_clock = 512;
constexpr Clock synchronizer_clocks = 2;
constexpr Clock symbol_clocks = 8;
constexpr std::array<Clock, 3> sampled_after = {12, 20, 28};  // an edge

// And rtl/time/sync_number.v these.
constexpr unsigned nothing = 3, mark = 2, message_periods = 64, number_bits = 42, parity_place = 43;

/// What a master sends for the period after this one.
unsigned symbol_after(std::uint64_t count) {
    const unsigned place = static_cast<unsigned>((count + 1) % message_periods);
    if (place == 0) return mark;
    if (place <= number_bits) return static_cast<unsigned>(count >> (48 - place) & 1U);
    return place == parity_place ? static_cast<unsigned>(std::popcount(count >> 6)) % 2 : 0;
}

}  // namespace

CarrierSync::CarrierSync(Clock period_clocks) : period_clocks_(period_clocks) {}

void CarrierSync::reset(Clock clock, Clock last, Role role) {
    if (driven_) drive(clock, false);
    rise_at_ = fall_at_ = never;
    role_ = role;
    reset_ = ended_ = last;
    edge_.reset();
    sampled_ = sampled_after.size();
    waited_ = 0;
    turn_ = in_step_ = false;
    cycles_ = waits_ = misses_ = 0;
    within_ = agreed_ = false;
    looks_.clear();
    if (!changes_.empty() && changes_.back().level) looks_.push_back(last + 1 + synchronizer_clocks);
}

void CarrierSync::wire(Clock clock, bool level) {
    const bool before = !changes_.empty() && changes_.back().level;
    if (before == level) return;
    changes_.push_back({clock, level});
    if (level) looks_.push_back(std::max(clock, reset_ + 1) + synchronizer_clocks);
    while (changes_.size() > 2 && changes_[1].clock + 4 * lead < clock) changes_.pop_front();
}

bool CarrierSync::level(Clock clock) const {
    if (clock < reset_ + 1 + synchronizer_clocks) return false;
    for (auto change = changes_.rbegin(); change != changes_.rend(); ++change)
        if (change->clock + synchronizer_clocks <= clock) return change->level;
    return false;
}

Clock CarrierSync::since(Clock clock) const { return edge_ ? std::min(clock - *edge_ - 1, unheard) : unheard; }

bool CarrierSync::rises(Clock clock) const {
    if (role_ == Role::master) return clock == master_rise();
    if (role_ != Role::slave || !level(clock) || level(clock - 1)) return false;
    if (!in_step_) return true;
    const Clock first = period_clocks_ - 2 - due - 8;
    const Clock place = std::min(clock - 1 - ended_, most_clock);
    return place >= first && place < first + 16 && since(clock) == unheard;
}

Clock CarrierSync::master_rise() const {
    return role_ == Role::master ? ended_ + 1 + period_clocks_ - lead + (turn_ ? 0 : 1) : never;
}

bool CarrierSync::waits(Clock clock) const {
    if (role_ == Role::alone) return false;
    if (role_ == Role::master) return !turn_ && waited_ == 0;
    const Clock heard = since(clock);
    if (in_step_ && heard == unheard) return part_ + rate_ >= parts_of_clock && waited_ == 0;
    return (heard < due || (heard > due + 7 && !in_step_)) && waited_ != most_waits;
}

bool CarrierSync::numbered(Clock clock) const {
    return role_ == Role::master || (agreed_ && (in_step_ || clock <= lost_at_ + 1));
}

Clock CarrierSync::next() const {
    const Clock rise = master_rise();
    return std::min(
        {looks_.empty() ? never : looks_.front(), edge_ && rise <= *edge_ ? never : rise, rise_at_, fall_at_});
}

CarrierSync::Step CarrierSync::step(Clock clock, bool last, std::uint64_t count) {
    Step step;
    const bool rise = rises(clock);
    while (!looks_.empty() && looks_.front() <= clock) looks_.pop_front();
    if (clock == rise_at_) drive(clock, true);
    if (clock == fall_at_) drive(clock, false);
    if (last) {
        step.holds = waits(clock);
        step.ends = !step.holds;
        if (step.holds) ++waited_;
    }
    if (rise && role_ == Role::slave) sample_symbol(clock);
    if (step.ends) end_cycle(clock, step, count);
    if (!rise) return step;
    edge_ = clock;
    if (role_ == Role::master) {
        rise_at_ = clock + 1;
        fall_at_ = rise_at_ + symbol_clocks * (symbol_after(count) + 1);
    } else if (!step.ends) {
        symbol_ = 0;
        sampled_ = 0;
    } else {
        sampled_ = 0;
    }
    return step;
}

/// The middle of each place in which the wire may have fallen, of those before this clock.
void CarrierSync::sample_symbol(Clock before) {
    for (; edge_ && sampled_ < sampled_after.size() && *edge_ + sampled_after[sampled_] < before; ++sampled_)
        symbol_ = (symbol_ + (level(*edge_ + sampled_after[sampled_]) ? 1U : 0U)) % 4;
}

void CarrierSync::end_cycle(Clock clock, Step& step, std::uint64_t count) {
    if (role_ == Role::slave) {
        const Clock heard = since(clock);
        const bool in_time = heard >= due && heard < due + 2 && waited_ < 3;
        const unsigned parts = part_ + rate_;
        const unsigned most = std::min(waits_ + waited_, parts_of_clock - 1);
        step.missed = in_step_ && !in_time;
        step.lost = step.missed && misses_ == misses_to_loss - 1;

        sample_symbol(clock);
        if (!in_step_) within_ = agreed_ = false;
        take_symbol(step.load, count);

        part_ = in_time && waited_ != 0              ? rate_ / 2
                : in_time && parts >= parts_of_clock ? parts_of_clock - 1
                                                     : parts % parts_of_clock;
        misses_ = in_time || !in_step_ ? 0 : (misses_ + 1) % misses_to_loss;
        cycles_ = in_time ? cycles_ + 1 : 0;
        waits_ = in_time ? most : 0;
        if (cycles_ == cycles_to_step) {
            in_step_ = true;
            rate_ = most;
            cycles_ = waits_ = 0;
        }
        if (step.lost) {
            in_step_ = false;
            lost_at_ = clock;
        }
        if (edge_ && sampled_ < sampled_after.size() && *edge_ + sampled_after[sampled_] == clock) ++sampled_;
    }
    symbol_ = nothing;
    ended_ = clock;
    waited_ = 0;
    turn_ = !turn_;
}

void CarrierSync::take_symbol(std::optional<std::uint64_t>& load, std::uint64_t count) {
    const unsigned bit = symbol_ % 2;
    const bool fits = within_ && symbol_ < mark && place_ != 0 &&
                      (place_ < parity_place || (place_ == parity_place ? (bit == 1) == odd_ : bit == 0));
    const std::uint64_t value = upper_ << 6 | (parity_place - 1);
    const bool whole = fits && place_ == parity_place;
    if (whole && count != value && !agreed_) load = value;
    if (in_step_) {
        within_ = symbol_ == mark || fits;
        if (whole) agreed_ = count == value;
    }
    if (place_ < parity_place) upper_ = (upper_ << 1 | bit) & ((std::uint64_t{1} << number_bits) - 1);
    odd_ = symbol_ != mark && odd_ != (bit == 1);
    place_ = symbol_ == mark ? 1 : (place_ + 1) % message_periods;
}

void CarrierSync::drive(Clock clock, bool level) {
    driven_ = level;
    (level ? rise_at_ : fall_at_) = never;
    if (on_change_) on_change_(clock, level);
}

}  // namespace haptogram::sim
