// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/link/clock.hpp"
#include "haptogram/link/outputs.hpp"
#include "haptogram/live/frame.hpp"
#include "haptogram/live/player.hpp"

namespace haptogram::live {

struct LoopOptions {
    unsigned misses_to_fade = 2;  ///< in a row
    double interval_s = 0.0;      ///< what a path takes on the line: frames that come faster are left out
    std::uint16_t watchdog_ms = 500;
};

/// What became of all. Counts are of shots unless said otherwise.
struct LoopReport : ShotCounts {
    std::uint64_t shots = 0;
    std::uint64_t lost = 0;          ///< numbers that never came
    std::uint64_t skipped = 0;       ///< came while the line was busy with an earlier one
    std::uint64_t out_of_order = 0;  ///< came after a later one, and were not used
    std::uint64_t blind = 0;         ///< no camera gave a picture; these are missed, too
    std::uint64_t given = 0;         ///< whose path went to the player; the feeler makes some that newer ones overtake
    std::uint64_t unsent = 0;     ///< the line had not taken what a shot made when the next one was there; missed, too
    std::uint64_t missed = 0;     ///< the ring was not on the board when the next shot was due, or none came
    std::uint64_t fades = 0;      ///< times that the outputs faded
    std::uint16_t underruns = 0;  ///< of the board
    std::vector<double> compute_s;  ///< of each shot
    std::vector<SentRing> rings;
};

/// Frames in, paths out: it takes frames as they come due by the clock, and between them keeps the path going.
class Loop {
public:
    Loop(link::Commands& device, link::Clock& clock, Player& player, const LoopOptions& options)
        : device_(device), clock_(clock), player_(player), options_(options) {}

    using Told = std::function<bool(const ShotReport&, const Frame&, const std::optional<Path>&)>;
    /// Turns the outputs on, plays until the source ends, `told` says false or, while a live source has no frame,
    /// `waits` does, and turns them off.
    /// @throws Error{device} when the board turns its outputs off by itself, does not confirm that they are off, or the
    /// link is lost
    LoopReport run(FrameSource& source, Feeler& feeler, const Told& told = {}, const std::function<bool()>& waits = {});

private:
    void play_all(FrameSource& source, Feeler& feeler, const Told& told, const std::function<bool()>& waits);
    bool await(FrameSource& source, const std::function<bool()>& waits);
    bool take(const Frame& frame, const FrameSource& source, Feeler& feeler, const Told& told);
    [[nodiscard]] ShotReport begin(const Frame& frame);
    void play(const std::optional<Path>& path, const ShotReport& shot);
    void serve_until(double time_s);
    void miss();

    link::Commands& device_;
    link::Clock& clock_;
    Player& player_;
    LoopOptions options_;
    double rate_hz_ = 30.0;  ///< of frames
    LoopReport report_;
    std::optional<double> last_time_s_;
    std::uint64_t last_number_ = 0;
    double begin_s_ = 0.0;  ///< by the clock, of the frames' time 0; of a live source that of its last frame
    unsigned misses_ = 0;   ///< in a row
    bool blind_ = false;    ///< the last shot had no picture
    unsigned absent_ = 0;   ///< of these, shots that were due since the last one and did not come
    bool holds_ = false;    ///< a shot is there, and waits for the line
};

/// @throws Error{failed} when frames made something to feel and nothing was played, when less than a quarter of the
/// paths that went to the player, less the frames that were skipped, began, or less than half was on the board in time
void require_played(const LoopReport& report);
/// That newer frames have overtaken most of those that made something to feel: a machine that is busy, or a board that
/// answers late. Empty when they have not.
[[nodiscard]] std::string overtaken_in_words(const LoopReport& report);

/// When each ring's first pulse left the board, after its shot.
struct Latency {
    std::size_t rings = 0;
    double least_s = 0.0, median_s = 0.0, most_s = 0.0;
    double uncertain_s = 0.0;  ///< by so much the latency of a ring may be off, at most
};
/// By the pins, which only simulated boards show. @param starts  changes of the record at the pins, in
/// their order: the time by the loop's clock, and the index
[[nodiscard]] Latency latency_of(std::span<const SentRing> rings,
                                 std::span<const std::pair<double, std::uint16_t>> starts);
/// By the device's own count of carrier periods; no rings when it has none.
[[nodiscard]] Latency latency_of(std::span<const SentRing> rings);

}  // namespace haptogram::live
