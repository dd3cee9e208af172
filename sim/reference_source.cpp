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
    after_reset_ = false;
    mode_ = mode;
    told_ = interface::Mode::idle;
    offered_ = ended_ = never;
    fetch_at_ = fetched_at_ = never;
    if (drop_last_ != clock) drop_first_ = clock + 1;  // otherwise two commands come one after the other
    drop_last_ = clock + 1;
}

void EntrySource::offer(Clock clock, Entry entry) {
    entry_ = entry;
    offered_ = clock + 1;
}

/// Silence for ever is the last entry; until it is taken, the mode is told as it was.
void EntrySource::finish(Clock clock) {
    told_ = std::exchange(mode_, interface::Mode::idle);
    ended_ = clock + 1;
    offer(clock, {});
}

void EntrySource::fetch(Clock clock, bool header) {
    fetch_at_ = clock + 1;
    fetches_header_ = header;
}

void EntrySource::select(Clock clock, Entry entry) {
    supplanted_at_ = clock;
    live_.clear();
    command(clock, interface::Mode::single);
    offer(clock, entry);
}

void EntrySource::start(Clock clock, std::uint16_t first, std::uint16_t length, std::uint16_t loops) {
    supplanted_at_ = clock;
    live_.clear();
    command(clock, interface::Mode::sequence);
    begin_sequence(clock, {first, length, loops});
}

void EntrySource::begin_sequence(Clock clock, Start start) {
    mode_ = interface::Mode::sequence;
    told_ = interface::Mode::idle;
    first_ = number_ = start.first;
    last_ = start.first + start.length - 1U;
    loops_ = start.loops;
    offered_ = ended_ = never;
    fetch(clock, start.length == 0);
}

void EntrySource::follow(Clock clock, Start start) {
    follower_ = start;
    follow_from_ = clock + 1;
}

void EntrySource::follow_now(Clock clock) {
    if (mode_ == interface::Mode::idle && offered_ == never) drop_silence_ = clock + 1;
    begin_sequence(clock, *follower_);
    follower_.reset();
    followed_ = true;
}

void EntrySource::stop(Clock clock) {
    live_.clear();
    command(clock, interface::Mode::idle);
    finish(clock);
}

void EntrySource::push(Clock clock, std::span<const Entry> entries, bool closed) {
    for (const Entry& entry : entries) live_.push_back({entry, closed ? never : clock + live_clocks});
    if (closed) return;
    supplanted_at_ = clock;
    ended_ = never;
    if (mode_ != interface::Mode::live) command(clock, interface::Mode::live);
}

void EntrySource::open(Clock clock) {
    supplanted_at_ = clock;
    for (Live& live : live_)
        if (live.visible == never) live.visible = clock + live_clocks;
    if (mode_ != interface::Mode::live) command(clock, interface::Mode::live);
}

void EntrySource::stream_begins(Clock clock) {
    if (!supplanted(clock)) stop(clock);
    stream_ = Stream{clock + 1};
}

void EntrySource::stream_ends(Clock clock) {
    stream_->to = clock;
    stream_->offered = never;
}

void EntrySource::stream_offers(Clock clock, std::uint16_t index) {
    stream_->offered = clock + 1;
    stream_->index = index;
}

void EntrySource::stream_withdraws(Clock clock) {
    stream_->offered = never;
    drop_silence_ = stream_drop_ = clock + 1;
}

void EntrySource::header_written(Clock clock, std::uint16_t half) {
    header_valid_ = in_range(half & 0x7fffU, sequence_.size());
    header_written_at_ = clock;
}

void EntrySource::reset(Clock clock) {
    mode_ = told_ = interface::Mode::idle;
    live_.clear();
    offered_ = never;
    after_reset_ = true;
    fetched_at_ = never;
    fetch(clock, true);
    drop_first_ = drop_silence_ = ended_ = never;
    drop_last_ = 0;
    follower_.reset();
}

Clock EntrySource::offered() const {
    if (stream_) return stream_->offered;
    if (mode_ != interface::Mode::live) return offered_;
    return live_.empty() ? never : live_.front().visible;
}

EntrySource::Entry EntrySource::take(Clock clock) {
    if (stream_) {
        stream_->offered = never;
        return {stream_->index, 0};
    }
    if (mode_ == interface::Mode::live) {
        const Entry entry = live_.front().entry;
        live_.pop_front();
        if (live_.empty()) ended_ = clock + 1;
        return entry;
    }
    const Entry entry = entry_;
    offered_ = never;
    told_ = interface::Mode::idle;
    if (mode_ == interface::Mode::single && entry.dwell == 0) ended_ = clock + 1;
    if (mode_ == interface::Mode::single && entry.dwell != 0) {
        if (follows(clock))
            follow_now(clock);
        else
            finish(clock);
        return entry;
    }
    if (mode_ == interface::Mode::sequence) {
        const bool at_last = number_ == last_;
        if (at_last && loops_ <= 1 && follows(clock)) {
            follow_now(clock);
            return entry;
        }
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

Clock EntrySource::next() const {
    const Clock followed = follower_ && ended_ != never ? std::max(follow_from_, ended_) : never;
    const Clock stream_ended = stream_ ? stream_->to : never;
    return std::min({fetch_at_, fetched_at_, drop_first_, drop_silence_, followed, stream_ended});
}

bool EntrySource::look_at_header(Clock clock) {
    const bool valid = in_range(interface::sequence_header_field::length.get(&word_), sequence_.size());
    if (header_written_at_ != clock) header_valid_ = valid;
    const bool starts = std::exchange(after_reset_, false);
    const bool by_itself = starts && alone_ && interface::sequence_header_field::autostart.get(&word_) != 0;
    return valid && (!starts || by_itself);
}

bool EntrySource::at(Clock clock) {
    if (follows(clock) && ended_ <= clock) follow_now(clock);
    if (mode_ == interface::Mode::live && !live_.empty()) ended_ = never;
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
                      static_cast<std::uint16_t>(interface::sequence_entry_field::dwell.get(&word_)),
                      interface::sequence_entry_field::mark.get(&word_) != 0, number_ == first_});
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
    if (drop_silence_ <= clock) drop_silence_ = never;
    if (stream_ && stream_->to <= clock) {
        stream_.reset();
        if (offered_ != never) offered_ = std::max(offered_, clock + 1);
        if (ended_ != never) ended_ = std::max(ended_, clock + 1);
    }
    if (clock < drop_first_) return;
    drop_first_ = clock == drop_last_ ? never : clock + 1;
}

}  // namespace haptogram::sim
