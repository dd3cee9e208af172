// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "haptogram/link/commands.hpp"

namespace haptogram::live {

/// A time that is known to lie between two others.
struct Between {
    double least = 0.0, most = 0.0;
    [[nodiscard]] double middle() const { return 0.5 * (least + most); }
    [[nodiscard]] double half() const { return 0.5 * (most - least); }
};

/// When entries of a device's live FIFO began, by the device's own count of carrier periods, which its status tells.
///
/// A status names the period and the record that plays, and with the level of the FIFO that record is a certain entry.
/// So this entry began within its dwell before that period. While the FIFO does not run empty, entries follow one
/// another without a gap, so every status narrows down when all of them began. A status also says that its period was
/// between the question and the answer by the host's clock, and many of them together put the count on that clock.
class BoardTime {
public:
    explicit BoardTime(double period_s) : period_s_(period_s) {}

    /// Entries that go into the FIFO, each for `dwell` periods; 0: until something else comes.
    void pushed(std::span<const std::uint16_t> indices, std::uint16_t dwell);
    [[nodiscard]] std::uint64_t entries() const { return first_ + entries_.size(); }

    /// @param entries  in all that were pushed before it was asked for
    /// @param asked_s, answered_s  by the host's clock
    void heard(const link::Status& status, std::uint64_t entries, double asked_s, double answered_s);

    /// When an entry began, by the host's clock, s; nothing when no status has shown it or a later one at the pins, or
    /// the FIFO ran empty around it.
    [[nodiscard]] std::optional<Between> began(std::uint64_t entry) const;
    /// Forgets what is only needed for entries before this one.
    void forget_before(std::uint64_t entry);

private:
    struct Entry {
        std::uint16_t index = 0, dwell = 0;
        std::uint64_t before = 0;  ///< periods that all entries before it last
    };
    /// Entries that follow one another without a gap. Entry e began `before` periods after a certain one.
    struct Row {
        std::uint64_t first = 0;            ///< entry
        std::optional<std::uint64_t> last;  ///< that was seen at the pins
        double least = -1e18, most = 1e18;  ///< the period from which `before` counts
    };
    struct Heard {
        double asked_s = 0.0, answered_s = 0.0, period = 0.0;
    };
    [[nodiscard]] std::optional<std::uint64_t> playing(const link::Status& status, std::uint64_t entries) const;

    double period_s_;
    std::uint64_t first_ = 0;  ///< number of the first entry that is kept
    std::deque<Entry> entries_;
    std::uint64_t periods_ = 0;  ///< of all entries
    std::deque<Row> rows_{Row{}};
    std::deque<Heard> heard_;
    std::optional<std::uint16_t> underruns_;
};

}  // namespace haptogram::live
