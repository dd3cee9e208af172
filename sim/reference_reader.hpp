// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"
#include "reference_source.hpp"

namespace haptogram::sim {

/// Reads one record at a time out of primary memory, a word a clock, while a host may write there
/// (rtl/memory_controller.v).
class RecordReader {
public:
    RecordReader(const interface::CoreParameters& p, const std::vector<std::uint16_t>& primary);

    /// Of what is being read, or has been read and waits.
    [[nodiscard]] bool holds() const { return load_.has_value(); }
    [[nodiscard]] const EntrySource::Entry& entry() const { return load_->entry; }
    [[nodiscard]] Clock taken() const { return load_->taken; }
    /// Whether it has words in memory, as far as is known; silence has none.
    [[nodiscard]] bool reads_words() const { return load_->count > 0; }
    /// A focus record is still to be found in memory.
    [[nodiscard]] bool seeks() const { return load_->ready == never; }
    /// The clock in which it is known whether it can be played, and from which on it can be, unless more is to be
    /// made of it.
    [[nodiscard]] Clock ready() const { return load_ ? load_->ready : never; }
    /// Its words, as they were found.
    [[nodiscard]] std::span<const std::uint16_t> words() const;

    /// @param focus  it is a focus record; place() or refuse() follows
    void take(Clock clock, EntrySource::Entry entry, bool focus);
    void place(std::uint32_t first, std::uint32_t words);
    void refuse();
    void drop() { load_.reset(); }

    /// Whether a word of primary memory, or any, is being read in this clock.
    [[nodiscard]] bool reads(Clock clock, std::uint32_t word) const;
    [[nodiscard]] bool reads(Clock clock) const;
    /// The last clock in which the record that is being loaded is read, unless it is dropped before.
    [[nodiscard]] Clock reads_to() const { return load_->from + load_->count; }
    /// A word of primary memory is written in this clock; to be called before its value changes.
    void written(Clock clock, std::uint32_t word, std::uint16_t value);

private:
    struct Load {
        Clock taken = 0, ready = 0;
        EntrySource::Entry entry;
        Clock from = 0;                                  // in which its first word is read
        std::uint32_t first = 0, count = 0;              // words of primary memory
        std::optional<std::vector<std::uint16_t>> seen;  // when the record was written after it had been read
    };

    std::uint32_t records_, record_words_;
    const std::vector<std::uint16_t>& primary_;
    std::optional<Load> load_;
};

}  // namespace haptogram::sim
