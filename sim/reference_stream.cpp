// SPDX-License-Identifier: Apache-2.0
#include "reference_stream.hpp"

namespace haptogram::sim {
namespace {

namespace stream_field = interface::stream_field;

constexpr Clock look_clocks = 3;   // from the arguments, or the last word, until a slot is looked at
constexpr Clock turn_clocks = 2;   // from the go point until it is decided what the period plays
constexpr Clock sweep_clocks = 2;  // until all slots are empty, beside one for each

}  // namespace

void PatternStream::set(Clock clock, std::uint32_t address, std::uint16_t word) {
    const bool form = address == static_cast<std::uint32_t>(interface::StreamWord::slot_form);
    words_[address] = form ? static_cast<std::uint16_t>(word & stream_field::slot_bits.most()) : word;
    forget(clock);
}

std::uint16_t PatternStream::fade() const { return static_cast<std::uint16_t>(stream_field::fade.get(words_)); }

bool PatternStream::usable(std::span<const std::uint16_t> parameters, std::uint32_t top_index) const {
    namespace set = interface::parameters_field;
    const std::uint64_t last = words_[0] + slots() - 1;
    if (slots() == 1 || slots() > p_.stream || words_[0] == 0 || last > 0xffff || fade() == 0) return false;
    if (!foci()) return last <= p_.records;
    const std::uint64_t words = 4ULL * (set::foci_last.get(parameters) + 1), number = last - p_.records;
    return last <= top_index && number <= set::foci_count.get(parameters) &&
           4ULL * set::foci_base.get(parameters) + number * words <= std::uint64_t{p_.records} * record_words_;
}

void PatternStream::begin(Clock clock, std::uint64_t period) {
    period_ = period;
    word_ = 0;
    look_ = clock + look_clocks;
    judged_ = false;
}

bool PatternStream::ready(Clock clock) {
    pass(clock);
    if (judged_) return true;
    if (clock == look_ && clock + 1 == turn_at_) ++look_;  // the slot whose turn it is goes first
    if (clock <= look_ || !(clock >= swept_from_ || forgets(clock))) return false;
    judged_ = true;
    refused_ = {};
    keeps_ = false;
    if (forgets(clock)) return false;
    const std::uint64_t ahead = this->ahead(period_);
    refused_.late = late(ahead);
    refused_.early = !refused_.late && ahead >= slots();
    refused_.repeated = !refused_.late && !refused_.early && waits_[slot(period_)];
    keeps_ = !refused_.late && !refused_.early && !refused_.repeated;
    return false;
}

std::optional<std::uint32_t> PatternStream::place(std::span<const std::uint16_t> parameters) const {
    namespace set = interface::parameters_field;
    if (!keeps_) return {};
    const std::uint32_t index = this->index(period_);
    if (!foci()) return (index - 1) * record_words_ + interface::record_header_words + word_;
    return 4 * (set::foci_base.get(parameters) + (index - p_.records - 1) * (set::foci_last.get(parameters) + 1)) +
           word_;
}

PatternStream::Counted PatternStream::take(Clock clock, std::span<const std::uint16_t> parameters) {
    const std::uint32_t words = foci() ? 4 * (interface::parameters_field::foci_last.get(parameters) + 1) : p_.channels;
    Counted counted;
    if (word_ == 0) counted = refused_;
    if (++word_ < words) return counted;
    if (keeps_ && late(ahead(period_)))
        counted.late = true;
    else if (keeps_ && !forgets(clock))
        waits_[slot(period_)] = true;
    begin(clock, (period_ + 1) & all);
    return counted;
}

void PatternStream::go(Clock clock, std::uint64_t count) {
    pass(clock);
    const bool follows = ((count + 1) & all) == decided_;
    decided_ = (count + 2) & all;
    if (!follows) forget(clock);
    turn_at_ = forgets(clock) ? never : clock + turn_clocks;
}

void PatternStream::end(Clock clock, bool forgets, bool held) {
    pass(clock + 1);
    if (held_) forget(clock);
    held_ = held;
    if (forgets || held) forget(clock + 1);
}

void PatternStream::forget(Clock clock) {
    forget_at_ = clock;
    swept_from_ = clock + sweep_clocks + p_.stream;
    forgotten_ = false;
}

/// What a clock before this one made it forget.
void PatternStream::pass(Clock clock) {
    if (forgotten_ || clock <= forget_at_) return;
    forgotten_ = true;
    waits_.assign(waits_.size(), false);
    if (turn_at_ <= forget_at_ + 1) turn_at_ = never;
    refused_ = {};
    keeps_ = false;
}

PatternStream::Turn PatternStream::turn(Clock clock, bool plays) {
    pass(clock);
    Turn turn;
    if (clock != turn_at_) return turn;
    turn_at_ = never;
    if (forgets(clock)) return turn;
    const std::size_t slot = this->slot(decided_);
    const bool full = waits_[slot] && clock >= swept_from_;
    waits_[slot] = false;
    if (full) {
        missed_ = 0;
        turn.index = index(decided_);
        return turn;
    }
    turn.lost = plays;
    turn.ends = plays && missed_ == stream_field::hold.get(words_);
    missed_ = (missed_ + 1) & 0xffffU;
    return turn;
}

}  // namespace haptogram::sim
