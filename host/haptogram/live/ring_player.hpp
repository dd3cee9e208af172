// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/format/path.hpp"
#include "haptogram/format/timer.hpp"
#include "haptogram/link/commands.hpp"
#include "haptogram/live/board_time.hpp"
#include "haptogram/live/clock.hpp"
#include "haptogram/solve/solver.hpp"

namespace haptogram::live {

/// A ring that went to the board.
struct SentRing {
    std::uint64_t shot = 0;         ///< whose it is
    double shot_s = 0.0;            ///< time of that shot
    double pushed_s = 0.0;          ///< when its first turn was pushed
    double expected_s = 0.0;        ///< when the board should begin it, by what is in its FIFO
    std::uint16_t first_index = 0;  ///< of its first step that sounds
    /// When that step began, by the device's count of carrier periods; nothing on devices that do not count them, and
    /// of rings that were silenced before a status showed them.
    std::optional<Between> began_s{};
};

/// Plays a ring over and over on a device, and replaces it by another as a whole, where a turn ends.
///
/// Each ring has records of its own in the device's memory, and turns go through the live FIFO, whole ones only.
/// Records are written again only after all turns with them have left the FIFO and another ring has begun. So whatever
/// is lost or late, no turn has steps of two rings. The FIFO holds little more than a turn, which is what a new ring
/// waits.
///
/// Nothing is waited for longer than a reply takes: service() does the next bit of work, and must be called again and
/// again while rings play.
class RingPlayer {
public:
    /// @param steps   of every ring
    /// @param method  for several foci at a time, by phases alone
    /// @param watchdog_ms  of the device, which hears from here in time, silent or not
    /// @throws Error{bad_input} when the device has too few channels for the array, or too few records or FIFO places
    RingPlayer(link::Commands& device, const Clock& clock, const Array& array, std::size_t steps, Method method,
               std::uint16_t watchdog_ms = 500);

    /// Begins to send a ring. What is not sent yet of the one before is dropped; what plays goes on until this one is
    /// complete.
    /// @param ring  steps of equal length, without a modulation
    /// @throws Error{bad_argument} for another ring, Error{bad_input} for foci that cannot be made
    void replace(const Path& ring, std::uint64_t shot, double shot_s);
    /// Silence where the present turn ends.
    void silence();
    /// What plays becomes weaker in two steps, each a ring of its own, and then silent.
    void fade();

    /// The next bit of work. @return whether there was any
    bool service();
    /// Whether a ring is not complete on the board yet.
    [[nodiscard]] bool sending() const { return next_.has_value(); }
    /// Whether a turn plays, or is under way.
    [[nodiscard]] bool playing() const { return present_.has_value(); }
    [[nodiscard]] bool fading() const { return !fades_.empty() || (present_ && present_->faded); }

    /// Asks the device where it is, so that sent() tells when the last rings began.
    void settle();
    [[nodiscard]] const std::vector<SentRing>& sent() const { return sent_; }
    [[nodiscard]] const Timer& timer() const { return timer_; }

private:
    struct Ring {
        Path path;
        SentRing about;
        std::size_t bank = 0;
        std::vector<link::Bytes> writes;  ///< payloads that are left to be sent, the last one first
        std::vector<std::uint16_t> indices;
        std::uint16_t dwell = 0;
        bool begun = false;  ///< a turn of it was pushed
        bool faded = false;  ///< it is a weaker copy
        /// The first step that sounds; 0 when none does.
        [[nodiscard]] std::size_t first_loud() const {
            const auto loud =
                std::find_if(path.steps.begin(), path.steps.end(), [](const PathStep& s) { return !s.foci.empty(); });
            return loud == path.steps.end() ? 0 : static_cast<std::size_t>(loud - path.steps.begin());
        }
    };
    struct Fifo;

    [[nodiscard]] Ring made(const Path& path, std::uint64_t shot, double shot_s) const;
    [[nodiscard]] std::optional<std::size_t> free_bank() const;
    void give_bank(Ring& ring, std::size_t bank) const;
    void push(const std::vector<std::uint16_t>& indices, std::uint16_t dwell);
    void submit(link::Request request, std::size_t entries = 0);
    void bring();
    [[nodiscard]] double level() const;
    void push_turn();
    void ask();
    void stamp(bool all);

    link::Commands& device_;
    Clock clock_;
    Array array_;
    std::size_t steps_;
    Method method_;
    Timer timer_;
    std::vector<std::uint64_t> free_at_;  ///< of each bank: how many entries must have left the FIFO
    std::shared_ptr<Fifo> fifo_;          ///< shared, because replies may come after this object is gone
    double said_s_;                       ///< when the device was told something last
    double pause_s_;                      ///< after which it must be told something again
    std::optional<Ring> present_, next_;
    std::deque<Path> fades_;
    std::vector<SentRing> sent_;
    std::shared_ptr<BoardTime> time_;  ///< empty when the device counts no periods
    /// Rings whose beginning is not told yet: their places in sent_, and their first entries that sound.
    std::deque<std::pair<std::size_t, std::uint64_t>> unstamped_;
    double entry_s_ = 0.0;  ///< that a FIFO entry lasts
};

}  // namespace haptogram::live
