// SPDX-License-Identifier: Apache-2.0
#include "reference_source.hpp"

#include <algorithm>
#include <utility>

namespace haptogram::sim {
namespace {

constexpr Clock memory_clocks = 2;  // from a word's address to the word
constexpr Clock live_clocks = 2;    // from the end of a PUSH until its indices can be taken

bool in_range(std::uint32_t length, std::size_t words) { return length > 0 && length < words; }

}  // namespace

void EntrySource::command(Clock clock, interface::Mode mode) {
    // A header that arrives in this clock is still looked at, but nothing follows from it.
    if (clock == fetched_at_ && fetches_header_) static_cast<void>(look_at_header(clock));
    mode_ = mode;
    offered_ = never;
    fetch_at_ = fetched_at_ = never;
    if (drop_last_ != clock) drop_first_ = clock + 1;  // otherwise two commands come one after the other
    drop_last_ = clock + 1;
}

void EntrySource::offer(Clock clock, Entry entry) {
    entry_ = entry;
    offered_ = clock + 1;
}

/// Silence for ever is the last entry.
void EntrySource::finish(Clock clock) {
    mode_ = interface::Mode::idle;
    offer(clock, {});
}

void EntrySource::fetch(Clock clock, bool header) {
    fetch_at_ = clock + 1;
    fetches_header_ = header;
}

void EntrySource::select(Clock clock, Entry entry) {
    live_.clear();
    command(clock, interface::Mode::single);
    offer(clock, entry);
}

void EntrySource::start(Clock clock, std::uint16_t first, std::uint16_t length, std::uint16_t loops) {
    live_.clear();
    command(clock, interface::Mode::sequence);
    first_ = number_ = first;
    last_ = first + length - 1U;
    loops_ = loops;
    fetch(clock, length == 0);
}

void EntrySource::stop(Clock clock) {
    live_.clear();
    command(clock, interface::Mode::idle);
    finish(clock);
}

void EntrySource::push(Clock clock, std::span<const Entry> entries) {
    for (const Entry& entry : entries) live_.push_back({entry, clock + live_clocks});
    if (mode_ != interface::Mode::live) command(clock, interface::Mode::live);
}

void EntrySource::header_written(Clock clock, std::uint16_t half) {
    header_valid_ = in_range(half & 0x7fffU, sequence_.size());
    header_written_at_ = clock;
}

void EntrySource::reset(Clock clock) {
    mode_ = interface::Mode::idle;
    live_.clear();
    offered_ = never;
    after_reset_ = true;
    fetched_at_ = never;
    fetch(clock, true);
    drop_first_ = never;
    drop_last_ = 0;
}

Clock EntrySource::offered() const {
    if (mode_ != interface::Mode::live) return offered_;
    return live_.empty() ? never : live_.front().visible;
}

EntrySource::Entry EntrySource::take(Clock clock) {
    if (mode_ == interface::Mode::live) {
        const Entry entry = live_.front().entry;
        live_.pop_front();
        return entry;
    }
    const Entry entry = entry_;
    offered_ = never;
    if (mode_ == interface::Mode::single && entry.dwell != 0) finish(clock);
    if (mode_ == interface::Mode::sequence) {
        const bool at_last = number_ == last_;
        if (at_last && loops_ == 1) {
            finish(clock);
        } else {
            fetch(clock, false);
        }
        number_ = at_last ? first_ : number_ + 1;
        if (at_last && loops_ != 0) --loops_;
    }
    return entry;
}

Clock EntrySource::next() const { return std::min({fetch_at_, fetched_at_, drop_first_}); }

bool EntrySource::look_at_header(Clock clock) {
    const bool valid = in_range(interface::sequence_header_field::length.get(&word_), sequence_.size());
    if (header_written_at_ != clock) header_valid_ = valid;
    const bool starts = std::exchange(after_reset_, false);
    const bool by_itself = starts && alone_ && interface::sequence_header_field::autostart.get(&word_) != 0;
    return valid && (!starts || by_itself);
}

bool EntrySource::at(Clock clock) {
    if (clock == fetch_at_) {
        word_ = sequence_[fetches_header_ ? 0 : number_];
        fetch_at_ = never;
        fetched_at_ = clock + memory_clocks;
        return false;
    }
    if (clock != fetched_at_) return false;
    fetched_at_ = never;
    if (!fetches_header_) {
        offer(clock, {static_cast<std::uint16_t>(interface::sequence_entry_field::index.get(&word_)),
                      static_cast<std::uint16_t>(interface::sequence_entry_field::dwell.get(&word_))});
        return false;
    }
    const bool starts = after_reset_;
    if (!look_at_header(clock)) {
        finish(clock);
        return false;
    }
    mode_ = interface::Mode::sequence;
    first_ = number_ = 1;
    last_ = interface::sequence_header_field::length.get(&word_);
    loops_ = interface::sequence_header_field::loops.get(&word_);
    fetch(clock, false);
    return starts;
}

void EntrySource::passed(Clock clock) {
    if (clock < drop_first_) return;
    drop_first_ = clock == drop_last_ ? never : clock + 1;
}

}  // namespace haptogram::sim
