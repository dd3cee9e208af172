// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <random>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/hand/ring_on_finger.hpp"
#include "haptogram/perception/tables.hpp"

namespace haptogram::live {

/// How sure a finger feels. The thresholds are those of the tables (perception/felt.hpp); these are ours.
struct SenseOptions {
    double contact_m = 10e-3;      ///< across the skin whose force counts as one
    double grip_n = 1.0;           ///< of the thresholds: a bare hand feels a little more
    double threshold_sd_db = 2.0;  ///< from one look to the next
    double place_sd_m = 1.5e-3;    ///< of where on the finger something is felt, along each direction
};

/// Something that a finger felt.
struct Sensed {
    Vec3 place;            ///< where it seems to be
    double over_db = 0.0;  ///< the strongest vibration over the least that is felt
};

/// A finger's skin under what is played: radiation pressure on it (hand/ring_on_finger.hpp), its vibration at each
/// place beside the threshold, and noise. A path that does not vibrate anywhere on the skin is not felt.
class SkinSense {
public:
    /// @throws Error{bad_argument} naming "grip" as perception/threshold.hpp does
    SkinSense(const Array& array, const SenseOptions& options);

    /// @param path    plays over and over, in steps of equal length; foci of one step count each by itself
    /// @return nothing when it is not felt, and for fingers of a size whose sound is unknown
    [[nodiscard]] std::optional<Sensed> feel(const Path& path, const FingerForm& finger, std::mt19937_64& random);

private:
    struct Patch {
        Vec3 place;
        double area = 0.0;
    };
    [[nodiscard]] std::vector<std::vector<double>> pressures(const Path& path, const std::vector<Patch>& skin,
                                                             const FingerForm& finger);
    static std::vector<Patch> skin_of(const FingerForm& finger);

    double carrier_hz_;
    SenseOptions options_;
    RingWeigher weigher_;
    perception::Tables tables_;
};

}  // namespace haptogram::live
