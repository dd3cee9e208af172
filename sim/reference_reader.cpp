// SPDX-License-Identifier: Apache-2.0
#include "reference_reader.hpp"

#include <algorithm>

namespace haptogram::sim {
namespace {

constexpr Clock silence_clocks = 2;      // from taking silence until it can be committed
constexpr Clock first_read = 2;          // from taking an entry to its first word's address
constexpr Clock load_clocks = 3;         // until it is ready, beside one for each word
constexpr Clock least_load_clocks = 33;  // the checks of a record's lengths take 24 clocks after its header
constexpr Clock first_focus_read = 4;    // it has to be found before
constexpr Clock focus_clocks = 7;
constexpr Clock least_focus_clocks = 29;

}  // namespace

RecordReader::RecordReader(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary)
    : records_(p.records), record_words_(p.channels + interface::record_header_words), primary_(primary) {}

void RecordReader::take(Clock clock, EntrySource::Entry entry, bool focus) {
    Load& load = load_.emplace();
    load.taken = clock;
    load.entry = entry;
    load.ready = focus ? never : clock + silence_clocks;
    if (entry.index == 0 || entry.index > records_) return;
    load.from = clock + first_read;
    load.first = (entry.index - 1U) * record_words_;
    load.count = record_words_;
    load.ready = clock + std::max(least_load_clocks, load_clocks + record_words_);
}

void RecordReader::place(std::uint32_t first, std::uint32_t words) {
    load_->from = load_->taken + first_focus_read;
    load_->first = first;
    load_->count = words;
    load_->ready = load_->taken + std::max(least_focus_clocks, focus_clocks + words);
}

void RecordReader::refuse() { load_->ready = load_->taken + first_focus_read; }

std::span<const std::uint16_t> RecordReader::words() const {
    if (load_->seen) return *load_->seen;
    return std::span(primary_).subspan(load_->first, load_->count);
}

/// In the clock after the last word one more is read, which does not count.
bool RecordReader::reads(Clock clock) const {
    return load_ && load_->count > 0 && clock >= load_->from && clock <= reads_to();
}

bool RecordReader::reads(Clock clock, std::uint32_t word) const {
    return reads(clock) && word == load_->first + (clock - load_->from);
}

void RecordReader::written(Clock clock, std::uint32_t word, std::uint16_t value) {
    if (!load_ || load_->ready < clock || word < load_->first || word >= load_->first + load_->count) return;
    const std::uint32_t place = word - load_->first;
    const bool was_read = clock > load_->from + place;
    if (was_read && !load_->seen) {
        const auto begin = primary_.begin() + load_->first;
        load_->seen.emplace(begin, begin + load_->count);
    } else if (!was_read && load_->seen) {
        (*load_->seen)[place] = value;
    }
}

}  // namespace haptogram::sim
