// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/array/vec3.hpp"
#include "haptogram/hand/touch.hpp"
#include "haptogram/live/frame.hpp"

namespace haptogram::live {

/// How a finger's place is taken forward over the latency, which is several milliseconds of a moving hand.
enum class Prediction {
    none,
    velocity,  ///< on with the velocity between the last two shots
    kalman,    ///< on with the velocity that a Kalman filter of constant velocity has learned, but no farther than the
               ///< last two shots and their noise say, so that it does not go on where a hand turns back
};
/// @throws Error{bad_argument} for other names than none, velocity and kalman
[[nodiscard]] Prediction prediction_of(std::string_view name);

struct PredictorOptions {
    Prediction kind = Prediction::none;
    double ahead_s = 0.0;            ///< the latency
    double place_noise_m = 0.3e-3;   ///< of the filter: standard deviation of a measured place
    double acceleration_m_s2 = 2.0;  ///< and of the hand's unforeseen acceleration
};

/// Follows fingers by their identities.
class Predictor {
public:
    /// @throws Error{bad_argument} for a latency that is negative, or noise that is not positive
    explicit Predictor(const PredictorOptions& options);
    /// Where a finger will be `ahead_s` after `now_s`, which is not before `measured_s`. A second place with the same
    /// `measured_s` is not a new measurement.
    [[nodiscard]] Vec3 ahead(std::uint64_t finger, Vec3 place, double measured_s, double now_s);
    /// Forgets all fingers that were last measured before a time.
    void forget_before(double time_s);

private:
    struct Track {
        double time_s = 0.0;
        Vec3 place, velocity, measured;
        double most_m_s = HUGE_VAL;        ///< of the velocity, that the last two places say
        std::array<double, 3> variance{};  ///< of place, of both together, and of velocity; the same in x, y and z
    };
    void filter(Track& track, Vec3 place, double seconds) const;

    PredictorOptions options_;
    std::map<std::uint64_t, Track> tracks_;
};

/// How a tracker's hands feel an object, as `render` has it.
struct HandOptions {
    Algorithm algorithm = Algorithm::intersection;
    TouchOptions touch;
    SkinOptions skin;
    PredictorOptions predict;
};

/// What there is to feel at a time.
struct ObjectsNow {
    TouchObject all;                 ///< as one
    std::vector<TouchObject> parts;  ///< each by itself
    std::vector<FeltObject> told;    ///< each as a scene tells it, in the same order
};

/// How many foci at a time an algorithm has, at most.
[[nodiscard]] std::size_t most_foci(const HandOptions& options);
/// Whether a pass takes seconds, for which no board has enough records.
[[nodiscard]] bool is_slow(const HandOptions& options);

/// A tracker's hands on a solid object: skin, algorithm, and one pass of the path, which repeats. What the array cannot
/// reach is silent, and so is skin that faces away from it.
class HandFeeler final : public Feeler {
public:
    using Objects = std::function<std::shared_ptr<const ObjectsNow>(double time_s)>;
    /// @throws Error{bad_argument} as touch_of() does, and for options of the prediction
    /// @param objects  what there is to feel at the time of a frame
    HandFeeler(const Array& array, double carrier_hz, Objects objects, const HandOptions& options);
    [[nodiscard]] std::optional<Path> feel(const Frame& frame, ShotReport& report) override;
    [[nodiscard]] ShotCounts counts() const override { return counts_; }
    /// How much of the surface of each object that there is at first the array reaches, and how strongly. Of one that
    /// comes later, or is of another kind or size than before, feel() says it.
    [[nodiscard]] std::string about() const override { return about_; }

private:
    [[nodiscard]] std::vector<std::string> news_of(const ObjectsNow& objects);
    [[nodiscard]] Hand ahead(Hand hand, double time_s);
    [[nodiscard]] Path pass_of(const Touch& touch, ShotReport& report);

    Array array_;
    double carrier_hz_;
    Objects objects_;
    HandOptions options_;
    Predictor predictor_;
    std::map<std::string, FeltObject> known_;  ///< of which it was said what the array reaches
    std::string about_;
    ShotCounts counts_;
};

}  // namespace haptogram::live
