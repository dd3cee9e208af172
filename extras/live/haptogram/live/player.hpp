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
#include "haptogram/format/timer.hpp"
#include "haptogram/link/clock.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/live/board_time.hpp"

namespace haptogram::live {

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
    /// Sends a request that puts so many entries into the FIFO.
    void send_entries(link::Request request, std::span<const std::uint16_t> indices, std::uint16_t dwell);
    void submit(link::Request request, std::size_t entries = 0) { submit_to(device_, std::move(request), entries); }
    void submit_to(link::Commands& device, link::Request request, std::size_t entries = 0);
    /// Keeps the watchdog quiet, and takes answers in. @return whether there was anything to do
    bool idle();
    [[nodiscard]] double level() const;
    /// A path begins with this entry, before which so many wait.
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
