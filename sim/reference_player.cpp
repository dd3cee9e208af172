// SPDX-License-Identifier: Apache-2.0
#include "reference_player.hpp"

#include <algorithm>

namespace haptogram::sim {
namespace {

constexpr Clock first_read = 2;          // from taking an entry to its first word's address
constexpr Clock silence_clocks = 2;      // from taking silence until it can be committed
constexpr Clock least_load_clocks = 33;  // the checks of a record's lengths take 24 clocks after its header
constexpr Clock load_clocks = 3;         // beside one for each word
constexpr Clock pin_clocks = 2;          // from the tick behind it to the pins

bool tame(const Firing& firing, std::uint32_t cycle_length) {
    return 2 * firing.pulse <= cycle_length && cycle_length >= 5;
}

}  // namespace

Player::Player(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary, EntrySource& source,
               PulseTrain& train)
    : p_(p),
      records_(p.records),
      record_words_(p.channels + interface::record_header_words),
      guard_window_(p.max_high_clocks / 2 - 1),
      primary_(primary),
      source_(source),
      train_(train),
      known_(p.records + 1) {}

void Player::reset(Clock clock) {
    load_.reset();
    idle_ = settled_ = clock + 1;
    change_ = never;
    late_ = false;
    cycle_length_ = carrier_period(p_);
    prescaler_ = 1;
    pulse_ = 0;
    firing_.reset();
    index_ = dwell_ = 0;
    first_ticks_.clear();
    train_.stop(clock);
    begin_cycle(clock, true, 0);
}

bool Player::reads(Clock clock) const {
    return load_ && from_memory(*load_) && clock >= load_->taken + first_read && clock <= reads_to();
}

Clock Player::reads_to() const { return load_->taken + first_read + record_words_; }

/// One word a clock, and the last one twice.
bool Player::reads(Clock clock, std::uint32_t word) const {
    return reads(clock) && word == load_->first + std::min<Clock>(clock - load_->taken - first_read, record_words_ - 1);
}

void Player::written(Clock clock, std::uint32_t word, std::uint16_t value) {
    if (!load_ || load_->done || !from_memory(*load_) || word < load_->first || word >= load_->first + record_words_)
        return;
    const std::uint32_t place = word - load_->first;
    const bool was_read = clock > load_->taken + first_read + place;
    if (was_read && !load_->seen) {
        const auto begin = primary_.begin() + load_->first;
        load_->seen.emplace(begin, begin + record_words_);
    } else if (!was_read && load_->seen) {
        (*load_->seen)[place] = value;
    }
}

Clock Player::take_at() const { return load_ ? never : std::max({idle_, settled_, source_.offered()}); }

Clock Player::next(bool waits) const {
    Clock found = std::min(end_, take_at());
    if (load_ && !load_->done) found = std::min(found, load_->ready);
    if (load_ && !waits && change_ != never) found = std::min(found, std::max({change_, load_->ready, settled_}));
    if (!first_ticks_.empty()) found = std::min(found, first_ticks_.front().next + pin_clocks);
    return found;
}

void Player::at(Clock clock, bool waits, bool off, bool hold, bool common, Counted& counted) {
    if (load_ && !load_->done && load_->ready == clock) finish_load(common, counted);
    const bool committed = boundary(clock, waits, hold, counted);
    if (source_.drops(clock)) {
        load_.reset();
        idle_ = clock + 1;
        change_ = clock + 1;
    } else if (source_.drops_silence(clock)) {
        load_.reset();
        idle_ = clock + 1;
    } else if (take_at() <= clock) {
        take(clock);
    }
    if (off && !committed) settled_ = std::min(settled_, clock + 1);
}

void Player::take(Clock clock) {
    Load& load = load_.emplace();
    load.taken = clock;
    load.ready = clock + silence_clocks;
    load.entry = source_.take(clock);
    if (!from_memory(load)) return;
    load.first = (load.entry.index - 1U) * record_words_;
    load.ready = clock + std::max(least_load_clocks, load_clocks + record_words_);
}

void Player::finish_load(bool common, Counted& counted) {
    load_->done = true;
    const std::size_t index = load_->entry.index;
    if (!from_memory(*load_)) {
        counted.refused = index != 0;
        return;
    }
    load_->record = load(load_->seen ? std::span<const std::uint16_t>(*load_->seen)
                                     : std::span(primary_).subspan(load_->first, record_words_),
                         index);
    counted.refused = !load_->record->playable || (common && !load_->record->common);
    if (counted.refused) load_->record.reset();
}

std::shared_ptr<const Player::Loaded> Player::load(std::span<const std::uint16_t> words, std::size_t index) {
    auto& known = known_[index];
    if (known && std::ranges::equal(known->words, words)) return known;
    auto loaded = std::make_shared<Loaded>();
    loaded->words.assign(words.begin(), words.end());
    loaded->cycle_length = interface::record_field::cycle_length.get(words);
    loaded->prescaler = interface::record_field::prescaler.get(words);
    const std::uint32_t pulse = interface::record_field::pulse_length.get(words);
    const std::uint64_t cycle_clocks = std::uint64_t{loaded->cycle_length} * loaded->prescaler;
    const std::uint64_t pulse_clocks = std::uint64_t{pulse} * loaded->prescaler;
    const std::uint64_t longest_pulse = (p_.max_high_clocks / 2 - 2) / 5;
    loaded->playable = interface::record_field::kind.get(words) == 0 && pulse < 1U << p_.pulse_bits &&
                       std::uint64_t{pulse} * 256 <= std::uint64_t{loaded->cycle_length} * p_.max_duty_256 &&
                       cycle_clocks > 0 && cycle_clocks <= p_.clock_hz && pulse_clocks <= longest_pulse &&
                       (pulse == 0 || pulse_clocks >= p_.min_pulse_clocks);
    loaded->common = cycle_clocks == carrier_period(p_);
    if (loaded->playable && pulse > 0) {
        auto firing = std::make_shared<Firing>();
        firing->pulse = pulse;
        firing->tick.assign(p_.channels, Firing::silent);
        const std::uint32_t no_tick = (1U << p_.timing_bits) - 1;  // and all above
        for (std::uint32_t channel = 0; channel < p_.channels; ++channel) {
            const std::uint32_t timing = words[interface::record_header_words + channel];
            if (timing >= no_tick || timing >= loaded->cycle_length) continue;
            firing->tick[channel] = timing;
            firing->rises.push_back({timing, channel});
        }
        std::ranges::stable_sort(firing->rises, {}, &Firing::Rise::tick);
        loaded->firing = std::move(firing);
    }
    known = loaded;
    return loaded;
}

/// @return whether a record was committed
bool Player::boundary(Clock clock, bool waits, bool hold, Counted& counted) {
    const bool ready = is_ready(clock);
    const bool asked = change_ <= clock;
    const bool at_once = !waits && asked && ready;  // nothing has to complete while outputs are off
    if (!last(clock) && !at_once) return false;
    if (hold && !at_once) {
        this->hold(clock);
        return false;
    }
    const bool due = dwell_ == 1;
    if (ready && (due || dwell_ == 0 || asked)) {
        commit(clock);
        return true;
    }
    if (due && !asked && !late_) {
        late_ = true;
        counted.underrun = true;
    }
    if (dwell_ > 1) --dwell_;
    begin_cycle(clock, false, 0);
    return false;
}

/// The cycle's last tick becomes a clock longer.
void Player::hold(Clock clock) {
    ++end_;
    if (settled_ > clock) ++settled_;
    if (cycle_length_ == 1) ++first_ticks_.back().next;
}

void Player::commit(Clock clock) {
    const std::uint32_t old_pulse = pulse_;
    pulse_ = 0;
    firing_.reset();
    if (load_->record) {
        cycle_length_ = load_->record->cycle_length;
        prescaler_ = load_->record->prescaler;
        firing_ = load_->record->firing;
        pulse_ = firing_ ? firing_->pulse : 0;
    }
    index_ = load_->entry.index;
    dwell_ = load_->entry.dwell;
    load_.reset();
    idle_ = clock + 1;
    change_ = never;
    late_ = false;
    settled_ = clock + 1 + (old_pulse == 0 ? 0 : Clock{old_pulse - 1} * prescaler_);
    begin_cycle(clock, true, old_pulse);
}

void Player::begin_cycle(Clock clock, bool committed, std::uint32_t old_pulse) {
    end_ = clock + Clock{cycle_length_} * prescaler_;
    train_.begin_cycle(clock, cycle_length_, prescaler_, firing_, committed, old_pulse);
    if (!first_ticks_.empty()) first_ticks_.back().next = std::min(first_ticks_.back().next, clock);
    first_ticks_.push_back({clock + prescaler_, index_});
    if (!firing_) return;
    // Pulses of at most half of equal cycles merge to less than four pulses, which the guard's window is longer than.
    const bool same = cycle_length_ == merge_cycle_ && prescaler_ == merge_prescaler_;
    if (!same || !tame(*firing_, cycle_length_))
        may_merge_to_ = clock + Clock{cycle_length_} * prescaler_ + 3 * guard_window_;
    merge_cycle_ = cycle_length_;
    merge_prescaler_ = prescaler_;
}

std::optional<Player::PinStart> Player::starts_at_pins(Clock clock) {
    if (first_ticks_.empty() || first_ticks_.front().next + pin_clocks != clock) return {};
    const PinStart start{clock, first_ticks_.front().index};
    first_ticks_.pop_front();
    return start;
}

}  // namespace haptogram::sim
