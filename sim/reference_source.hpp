// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "clock.hpp"
#include "haptogram/format/interface.hpp"

namespace haptogram::sim {

/// What to play next: entries of an index and a dwell, from a command, sequence memory or the live FIFO (rtl/README.md,
/// contract 6).
class EntrySource {
public:
    struct Entry {
        std::uint16_t index = 0, dwell = 0;
        bool mark = false, pass = false;  ///< of a sequence: it has one, a pass begins with it
    };

    EntrySource(const interface::CoreParameters& p, const std::vector<std::uint32_t>& sequence)
        : live_depth_(p.live_depth), sequence_(sequence) {}

    // Commands, in the clock in which they are carried out. Each but push() drops what is being prepared, a clock
    // later; push() does so when it enters live mode.
    void select(Clock clock, Entry entry);
    /// @param length  0: length and loops are what the sequence header says
    void start(Clock clock, std::uint16_t first, std::uint16_t length, std::uint16_t loops);
    void stop(Clock clock);
    /// @param closed  they wait until open()
    void push(Clock clock, std::span<const Entry> entries, bool closed);
    void open(Clock clock);
    /// A START that waits for the end of what plays; it begins at(), without dropping anything but silence.
    struct Start {
        std::uint16_t first, length, loops;
    };
    void follow(Clock clock, Start start);
    void drop_follower() { follower_.reset(); }

    /// A stream (PatternStream) plays from the next clock on, in the place of all entries from here, which end.
    void stream_begins(Clock clock);
    /// It plays in this clock for the last time.
    void stream_ends(Clock clock);
    /// Its next entry can be taken from the next clock on.
    void stream_offers(Clock clock, std::uint16_t index);
    /// From the next clock on there is none; what was loaded of it is dropped then.
    void stream_withdraws(Clock clock);
    [[nodiscard]] bool streams(Clock clock) const { return stream_ && stream_->from <= clock && clock <= stream_->to; }
    /// Whether a command has begun something else in this clock.
    [[nodiscard]] bool supplanted(Clock clock) const { return clock == supplanted_at_; }
    /// Whether one began since the last call.
    [[nodiscard]] bool followed() { return std::exchange(followed_, false); }
    /// The lower half of the sequence header is written.
    void header_written(Clock clock, std::uint16_t half);
    /// A host has done more than ask: no autostart follows any more.
    void host_takes_over() { alone_ = false; }
    [[nodiscard]] bool alone() const { return alone_; }
    void reset(Clock clock);

    [[nodiscard]] interface::Mode mode() const { return mode_ != interface::Mode::idle ? mode_ : told_; }
    [[nodiscard]] bool header_valid() const { return header_valid_; }
    [[nodiscard]] std::uint16_t live_level() const { return static_cast<std::uint16_t>(live_.size()); }
    [[nodiscard]] std::uint32_t live_free() const { return live_depth_ - live_level(); }
    /// Whether sequence memory is being read for the player in this clock.
    [[nodiscard]] bool fetching(Clock clock) const { return clock == fetch_at_; }
    /// Whether what is being prepared is dropped in this clock.
    [[nodiscard]] bool drops(Clock clock) const { return drop_first_ <= clock && clock <= drop_last_; }
    /// Whether silence that is being prepared, or is prepared, is dropped in this clock.
    /// What a stream has offered is dropped; until then it plays nothing before its time.
    [[nodiscard]] bool drops_stream(Clock clock) const { return clock == stream_drop_; }
    [[nodiscard]] bool drops_silence(Clock clock) const { return clock == drop_silence_; }
    /// The clock from which on an entry can be taken.
    [[nodiscard]] Clock offered() const;
    Entry take(Clock clock);

    [[nodiscard]] Clock next() const;
    /// Goes on fetching. @return true when the sequence starts by itself
    bool at(Clock clock);
    /// To be called last in each clock.
    void passed(Clock clock);

private:
    struct Live {
        Entry entry;
        Clock visible;
    };

    void command(Clock clock, interface::Mode mode);
    void offer(Clock clock, Entry entry);
    void finish(Clock clock);
    void fetch(Clock clock, bool header);
    bool look_at_header(Clock clock);
    void begin_sequence(Clock clock, Start start);
    [[nodiscard]] bool follows(Clock clock) const { return follower_ && follow_from_ <= clock && !streams(clock); }
    void follow_now(Clock clock);

    std::uint32_t live_depth_;
    const std::vector<std::uint32_t>& sequence_;
    interface::Mode mode_ = interface::Mode::idle, told_ = interface::Mode::idle;  // told: instead of idle
    Clock offered_ = never;                                                        // not used in live mode
    Entry entry_;
    std::deque<Live> live_;
    Clock fetch_at_ = never, fetched_at_ = never;
    bool fetches_header_ = false;
    std::uint32_t word_ = 0;
    std::uint32_t first_ = 0, last_ = 0, number_ = 0, loops_ = 0;
    bool header_valid_ = false;
    Clock header_written_at_ = never;
    bool after_reset_ = true;  // neither a header has been looked at since reset, nor a command come
    bool alone_ = true;
    Clock drop_first_ = never, drop_last_ = 0;
    std::optional<Start> follower_;
    Clock follow_from_ = never, ended_ = never;  // from which on it may begin, and nothing is left of what plays
    Clock stream_drop_ = never, drop_silence_ = never;
    bool followed_ = false;
    struct Stream {
        Clock from, to = never, offered = never;
        std::uint16_t index = 0;
    };
    std::optional<Stream> stream_;
    Clock supplanted_at_ = never;
};

}  // namespace haptogram::sim
