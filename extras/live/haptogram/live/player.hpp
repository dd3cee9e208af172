// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/schedule.hpp"
#include "haptogram/link/clock.hpp"
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

/// A path that went to the board. One of rings is called a ring.
struct SentRing {
    std::uint64_t shot = 0;         ///< the frame whose it is
    double shot_s = 0.0;            ///< time of that frame
    double pushed_s = 0.0;          ///< when its beginning was pushed
    double expected_s = 0.0;        ///< when the board should begin it, by what is in its FIFO
    std::uint16_t first_index = 0;  ///< of its first step that sounds
    /// When that step began, by the device's count of carrier periods; nothing on devices that do not count them, and
    /// of paths that were silenced before a status showed them.
    std::optional<Between> began_s{};
};

/// One of the boards that a device's channels are on, and how many of the array's elements it drives, in their order.
struct DevicePart {
    link::Commands& device;
    std::size_t elements = 0;
};
/// The parts of a device that is one board.
[[nodiscard]] inline std::vector<DevicePart> one_part(link::Commands& device, const Array& array) {
    return {{device, array.elements.size()}};
}

/// How fast the line to a device is, measured by reading from its memory.
struct Line {
    double bytes_s = 0.0;  ///< bytes a second, one way
    double trip_s = 0.0;   ///< of a question and its answer without their bytes
};
[[nodiscard]] Line measured_line(link::Commands& device, link::Clock& clock);

/// Plays a path over and over on a device, and takes another instead when it is told to.
///
/// Nothing is waited for longer than a reply takes: service() does the next bit of work, and must be called again and
/// again while something plays.
class Player {
public:
    Player(const Player&) = delete;
    Player& operator=(const Player&) = delete;
    virtual ~Player() = default;

    /// Begins to send a path. What is not sent yet of the one before is dropped.
    /// @throws Error{bad_argument} for a path that this player cannot play
    virtual void replace(const Path& path, std::uint64_t shot, double shot_s) = 0;
    /// Silence as soon as may be.
    virtual void silence() = 0;
    /// What plays becomes weaker in two steps, and then silent.
    virtual void fade() = 0;

    /// The next bit of work. @return whether there was any
    virtual bool service() = 0;
    /// Whether the newest path does not play yet.
    [[nodiscard]] virtual bool sending() const = 0;
    /// Whether something plays, or is under way.
    [[nodiscard]] virtual bool playing() const = 0;
    [[nodiscard]] virtual bool fading() const = 0;

    /// Asks the device where it is, so that sent() tells when the last paths began.
    void settle();
    [[nodiscard]] const std::vector<SentRing>& sent() const { return sent_; }
    [[nodiscard]] const Timer& timer() const { return timer_; }

protected:
    /// @param watchdog_ms  of the device, which hears from here in time, silent or not
    Player(link::Commands& device, link::Clock& clock, const Timer& timer, std::uint16_t watchdog_ms);

    /// What the last reply said of the FIFO. All replies tell its level.
    struct Fifo {
        std::uint64_t pushed = 0;     ///< entries, in all
        std::uint64_t under_way = 0;  ///< of these, in frames that are not answered yet
        std::uint64_t level = 0;      ///< as the last reply said
        double told_s = 0.0;          ///< when it came
        std::uint16_t underruns = 0;  ///< as the last status said
        [[nodiscard]] std::uint64_t left() const { return pushed - under_way - level; }
    };

    void push(std::span<const std::uint16_t> indices, std::uint16_t dwell);
    /// Sends a request that puts this many entries into the FIFO.
    void send_entries(link::Request request, std::span<const std::uint16_t> indices, std::uint16_t dwell);
    void submit(link::Request request, std::size_t entries = 0) { submit_to(device_, std::move(request), entries); }
    void submit_to(link::Commands& device, link::Request request, std::size_t entries = 0);
    /// Keeps the watchdog quiet, and takes answers in. @return whether there was anything to do
    bool idle();
    [[nodiscard]] double level() const;
    /// A path begins with this entry, before which this many entries wait.
    void begins(SentRing about, std::uint64_t entry, double waiting);
    /// Asks for the status, and stamps what can be by it.
    void ask();

    link::Commands& device_;
    link::Clock& clock_;
    Timer timer_;
    std::shared_ptr<Fifo> fifo_;       ///< shared, because replies may come after this object is gone
    std::shared_ptr<BoardTime> time_;  ///< empty when the device counts no periods
    double entry_s_ = 0.0;             ///< that a FIFO entry lasts

private:
    void stamp(bool all);

    double said_s_;   ///< when the device was told something last
    double pause_s_;  ///< after which it must be told something again
    std::vector<SentRing> sent_;
    /// Paths whose beginning is not told yet: their places in sent_, and their first entries that sound.
    std::deque<std::pair<std::size_t, std::uint64_t>> unstamped_;
};

}  // namespace haptogram::live
