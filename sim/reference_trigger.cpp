// SPDX-License-Identifier: Apache-2.0
#include "reference_trigger.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace haptogram::sim {
namespace {

namespace trigger_bits = interface::trigger_field;
using interface::Event;
using interface::Test;
using Word = interface::TriggerWord;

constexpr Clock trigger_pin_clocks = 2;  // from the pin until it is seen
constexpr Clock known_clocks = 3;        // from the last clock of a reset until it is looked at
constexpr Clock gate_clocks = 2;         // from the input's change until what waits for it begins

}  // namespace

TriggerPins::TriggerPins(const interface::CoreParameters& p) {
    for (const auto& f :
         {trigger_bits::event, trigger_bits::out_periods, trigger_bits::out_length, trigger_bits::in_low,
          trigger_bits::in_level, trigger_bits::in_gates, trigger_bits::in_least, trigger_bits::test})
        f.set(masks_, f.most());
    masks_[static_cast<unsigned>(Word::test_channel)] =
        static_cast<std::uint16_t>((1U << std::bit_width(p.channels - 1)) - 1);
}

void TriggerPins::drive(Clock clock, bool level) {
    while (!changes_.empty() && changes_.back().clock >= clock + trigger_pin_clocks) changes_.pop_back();
    changes_.push_back({clock + trigger_pin_clocks, level});
}

Clock TriggerPins::next() const {
    if (last_ < wake_to_) return last_ + 1;
    Clock found = std::min({happens_at_, starts_at_, falls_at_, turns_at_});
    if (!changes_.empty()) found = std::min(found, changes_.front().clock - 1);
    return std::max(found, last_ + 1);
}

void TriggerPins::edge(Clock clock, const Ports& ports) {
    const bool resets = reset_from_ <= clock && clock <= reset_to_, was_active = active_;
    if (resets) wake_to_ = reset_to_ + known_clocks;
    output(clock, resets);
    input(clock, resets);
    settle(clock);
    look_at_input(clock, resets, active_ != was_active);
    look_at_ports(clock, ports);
    last_ = clock;
}

void TriggerPins::set_level(Clock clock, bool level) {
    if (std::exchange(level_, level) != level && on_change_) on_change_(clock, level);
}

void TriggerPins::output(Clock clock, bool resets) {
    const bool happens = happens_at_ == clock;
    if (happens) {
        ++out_count_;
        out_clock_ = clock + 1;
    }
    if (resets || falls_at_ == clock) falls_at_ = never;
    if (happens && !resets) falls_at_ = clock + std::max(get(trigger_bits::out_length), 1U);
    set_level(clock, falls_at_ != never);
    if (starts_at_ == clock) left_ = left_ > 0 ? left_ - 1 : std::max(get(trigger_bits::out_periods), 1U) - 1;
}

void TriggerPins::input(Clock clock, bool resets) {
    const bool was_active = active_, turns = turns_at_ == clock && !resets;
    active_ = !resets && active_ != turns;
    const bool begins = turns && active_;
    if (begins) {
        ++in_count_;
        in_clock_ = differs_from_ - trigger_pin_clocks;
    }
    const bool by_level = get(trigger_bits::in_level) != 0;
    while (!fires_.empty() && fires_.back().clock >= clock) fires_.pop_back();
    fires_.push_back({clock, !resets && (by_level ? was_active : begins)});
    if (turns || begins) wake_to_ = std::max(wake_to_, clock + gate_clocks + 2);
}

/// What was written in this clock holds from the next one on.
void TriggerPins::settle(Clock clock) {
    if (!written_) return;
    const auto [address, word] = *std::exchange(written_, std::nullopt);
    words_[address] = static_cast<std::uint16_t>(word & masks_[address]);
    if (address <= static_cast<std::uint32_t>(Word::out_periods)) left_ = 0;
    wake_to_ = std::max(wake_to_, clock + gate_clocks + 2);
}

/// What the next clock finds.
void TriggerPins::look_at_input(Clock clock, bool resets, bool turned) {
    while (!changes_.empty() && changes_.front().clock <= clock + 1) {
        pin_ = changes_.front().level;
        changes_.pop_front();
    }
    const bool known = reset_to_ + known_clocks <= clock + 1;
    const bool differs = (known && pin_ != (get(trigger_bits::in_low) != 0)) != active_;
    if (!differs)
        differs_from_ = never;
    else if (differs_from_ == never || turned || resets)
        differs_from_ = clock + 1;
    turns_at_ = differs ? std::max(clock + 1, differs_from_ + get(trigger_bits::in_least)) : never;
    mute_ = get(trigger_bits::in_gates) != 0 && !active_;
    fires_.push_back({clock + 1, get(trigger_bits::in_level) != 0 && active_});
    while (fires_.size() > 2 && fires_[1].clock + gate_clocks <= clock) fires_.pop_front();
}

void TriggerPins::look_at_ports(Clock clock, const Ports& ports) {
    const auto event = static_cast<Event>(get(trigger_bits::event));
    const bool samples = ports.starts && samples_from_ <= clock + 1;
    if (samples) samples_from_ = never;
    if (ports.samples) samples_from_ = std::min(samples_from_, clock + 2);
    const bool begins = ports.starts && ports.enabled;
    const bool happens = (event == Event::start && ports.playing && !ports_.playing) ||
                         (event == Event::mark && begins && ports.mark) ||
                         (event == Event::pass && begins && ports.pass) ||
                         (event == Event::period && ports.starts && left_ == 0) || (event == Event::samples && samples);
    happens_at_ = happens ? clock + 1 : never;
    starts_at_ = ports.starts && event == Event::period ? clock + 1 : never;
    if (ports.starts) {
        cycles_ = !cycles_;
        cycle_at_ = clock;
    }
    if (ports.index != ports_.index) {
        changes_of_index_ = !changes_of_index_;
        index_at_ = clock;
    }
    ports_ = ports;
}

bool TriggerPins::comes(Clock clock) const {
    bool found = false;
    for (const Change& change : fires_)
        if (change.clock + gate_clocks <= clock) found = change.level;
    return found;
}

void TriggerPins::answer(Clock clock) {
    const auto tell = [this](const interface::BitField& low, Word high, std::uint64_t value) {
        low.set(words_, value & low.most());
        words_[static_cast<unsigned>(high)] = static_cast<std::uint16_t>(value >> low.width);
    };
    tell(trigger_bits::now, Word::now_high, clock);
    tell(trigger_bits::out, Word::out_high, out_clock_);
    tell(trigger_bits::in, Word::in_high, in_clock_);
    trigger_bits::out_count.set(words_, out_count_ & trigger_bits::out_count.most());
    trigger_bits::in_count.set(words_, in_count_ & trigger_bits::in_count.most());
}

std::uint16_t TriggerPins::word(std::uint32_t address) const { return words_[address]; }

bool TriggerPins::test(Clock last, const std::function<bool(std::uint32_t)>& pin) const {
    switch (static_cast<Test>(get(trigger_bits::test))) {
        case Test::off: return false;
        case Test::carrier: return pin(words_[static_cast<unsigned>(Word::test_channel)]);
        case Test::cycle: return cycles_ != (cycle_at_ == last);
        case Test::index: return changes_of_index_ != (index_at_ == last);
    }
    return false;
}

}  // namespace haptogram::sim
