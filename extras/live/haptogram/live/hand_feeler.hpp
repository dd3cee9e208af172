// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "haptogram/array/array.hpp"
#include "haptogram/hand/touch.hpp"
#include "haptogram/live/frame.hpp"
#include "haptogram/live/prediction.hpp"

namespace haptogram::live {

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
