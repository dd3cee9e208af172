// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string_view>

#include "haptogram/array/vec3.hpp"

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
    /// Where a finger will be `ahead_s` after a time, not earlier than that at which it was measured. One measured at
    /// the time of the last one is no new one.
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

}  // namespace haptogram::live
