// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/link/outputs.hpp"
#include "haptogram/live/clock.hpp"
#include "haptogram/live/ring_player.hpp"
#include "haptogram/live/shot_rings.hpp"

namespace haptogram::live {

struct LoopOptions : FingerOptions {
    Method method = Method::distance_weighted;  ///< of several fingers at once; the paper's
    unsigned misses_to_fade = 2;                ///< in a row
    std::uint16_t watchdog_ms = 500;
};

/// What became of all. Counts are of shots unless said otherwise.
struct LoopReport : ShotCounts {
    std::uint64_t shots = 0;
    std::uint64_t lost = 0;          ///< numbers that never came
    std::uint64_t out_of_order = 0;  ///< came after a later one, and were not used
    std::uint64_t blind = 0;         ///< no camera gave a picture; these are missed, too
    std::uint64_t missed = 0;        ///< the ring was not on the board when the next shot was due, or none came
    std::uint64_t fades = 0;         ///< times that the outputs faded
    std::uint16_t underruns = 0;     ///< of the board
    std::vector<double> compute_s;   ///< of each shot
    std::vector<SentRing> rings;
};

/// The loop of Fingers: depth, points, fingers, forces, sections, rings, board. It takes shots as they come due by the
/// clock, and between them keeps the ring turning.
class Loop {
public:
    /// @throws Error as the parts do, naming the option
    Loop(link::Commands& device, const Clock& clock, const Array& array, const LoopOptions& options);

    using Told = std::function<bool(const ShotReport&, const DepthShot&)>;
    /// Turns the outputs on, plays until the source ends, `told` says false or, while a live source has no shot,
    /// `waits` does, and turns them off.
    /// @throws Error{device} when the board turns its outputs off by itself, does not confirm that they are off, or the
    /// link is lost
    LoopReport run(DepthSource& source, const Told& told = {}, const std::function<bool()>& waits = {});

private:
    void play_all(DepthSource& source, const Told& told, const std::function<bool()>& waits);
    bool await(DepthSource& source, const std::function<bool()>& waits);
    bool take(const DepthShot& shot, const DepthSource& source, const Told& told);
    [[nodiscard]] ShotReport begin(const DepthShot& shot);
    void play(const std::optional<Path>& rings, const ShotReport& shot);
    void serve_until(double time_s);
    void miss();

    link::Commands& device_;
    Clock clock_;
    LoopOptions options_;
    RingPlayer player_;
    ShotRings fingers_;
    LoopReport report_;
    std::optional<double> last_time_s_;
    std::uint64_t last_number_ = 0;
    double begin_s_ = 0.0;  ///< by the clock, of the shots' time 0; of a live source that of its last shot
    unsigned misses_ = 0;   ///< in a row
    bool blind_ = false;    ///< the last shot had no picture
    unsigned absent_ = 0;   ///< of these, shots that were due since the last one and did not come
};

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
