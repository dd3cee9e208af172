// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptogram/link/outputs.hpp"
#include "haptogram/live/clock.hpp"
#include "haptogram/live/prediction.hpp"
#include "haptogram/live/ring_player.hpp"
#include "haptogram/render/ring.hpp"
#include "haptogram/render/section.hpp"
#include "haptogram/scene/touch_scene.hpp"
#include "haptogram/sense/cloud.hpp"

namespace haptogram::live {

struct LoopOptions {
    CloudOptions cloud;
    SceneOptions scene;
    SectionOptions section;
    RingOptions ring;
    PredictorOptions predict;
    Method method = Method::distance_weighted;  ///< of several fingers at once; the paper's
    double rate_hz = 30.0;                      ///< of shots: the next one is missed when it is half a shot late
    unsigned misses_to_fade = 2;                ///< in a row
    std::uint16_t watchdog_ms = 500;
};

/// What became of one shot.
struct ShotReport {
    std::uint64_t number = 0;
    double time_s = 0.0;
    std::size_t points = 0, fingers = 0, foci = 0;  ///< foci: rings that play at the same time
    std::vector<Ellipse> sections;                  ///< of these, where they were measured
    std::vector<Vec3> centres;                      ///< and where they play, predicted
    Pose object;
    double force_n = 0.0;               ///< the sum of the fingers' forces' magnitudes on the object
    double compute_s = 0.0;             ///< processor time from the pictures to the ring
    std::vector<std::string> troubles;  ///< whole sentences
};

/// What became of all. Counts are of shots unless said otherwise.
struct LoopReport {
    std::uint64_t shots = 0, with_rings = 0;
    std::uint64_t lost = 0;            ///< numbers that never came
    std::uint64_t out_of_order = 0;    ///< came after a later one, and were not used
    std::uint64_t empty = 0;           ///< nothing in the workspace
    std::uint64_t without_camera = 0;  ///< a camera gave no picture
    std::uint64_t through = 0;         ///< a finger was behind the object's middle
    std::uint64_t no_section = 0;      ///< a finger's points were no ellipse of a finger's size
    std::uint64_t constrained = 0;     ///< a section was seen from one side
    std::uint64_t out_of_reach = 0;    ///< a ring was where the array makes no focus
    std::uint64_t missed = 0;          ///< the ring was not on the board when the next shot was due, or none came
    std::uint64_t fades = 0;           ///< times that the outputs faded
    std::uint16_t underruns = 0;       ///< of the board
    std::vector<double> compute_s;     ///< of each shot
    std::vector<SentRing> rings;
};

/// The loop of Fingers: depth, points, fingers, forces, sections, rings, board. It takes shots as they come due by the
/// clock, and between them keeps the ring turning.
class Loop {
public:
    /// @throws Error as the parts do, naming the option
    Loop(link::Commands& device, const Clock& clock, const Array& array, const LoopOptions& options);

    using Told = std::function<bool(const ShotReport&, const DepthShot&)>;
    /// Turns the outputs on, plays until the source ends or `told` says false, and turns them off.
    /// @throws Error{device} when the board turns its outputs off by itself, or the link is lost
    LoopReport run(DepthSource& source, const Told& told = {});

private:
    struct Wanted {
        std::vector<Ellipse> sections;  ///< where they play
        std::vector<std::optional<Vec3>> starts;
        std::vector<std::uint64_t> fingers;
    };
    bool take(const DepthShot& shot, std::span<const DepthCamera> cameras, const Told& told);
    void gather(const SceneFinger& finger, const std::optional<Vec3>& sight, ShotReport& shot, Wanted& wanted);
    void play(const Wanted& wanted, const ShotReport& shot);
    void serve_until(double time_s);
    void miss();

    link::Commands& device_;
    Clock clock_;
    Array array_;
    LoopOptions options_;
    CloudMaker clouds_;
    TouchScene scene_;
    Predictor predictor_;
    RingPlayer player_;
    LoopReport report_;
    std::map<std::uint64_t, Vec3> last_start_;  ///< by finger: where its ring begins
    std::optional<double> last_time_s_;
    std::uint64_t last_number_ = 0;
    double begin_s_ = 0.0;  ///< by the clock, of the shots' time 0
    unsigned misses_ = 0;   ///< in a row
    unsigned absent_ = 0;   ///< of these, shots that were due since the last one and did not come
};

/// When each ring's first pulse left the board, after its shot. @param starts  changes of the record at the pins, in
/// their order: the time by the loop's clock, and the index
struct Latency {
    std::size_t rings = 0;
    double least_s = 0.0, median_s = 0.0, most_s = 0.0;
};
[[nodiscard]] Latency latency_of(std::span<const SentRing> rings,
                                 std::span<const std::pair<double, std::uint16_t>> starts);

}  // namespace haptogram::live
