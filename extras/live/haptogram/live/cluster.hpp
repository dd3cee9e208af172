// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// Points that belong together, and their mean.
struct Cluster {
    std::vector<Vec3> points;
    Vec3 centroid;
};

/// The connected components of the graph in which points at most a distance apart are joined (Fingers, section 3,
/// "Physics simulation"), the largest first; of equal ones, that of the earlier point. The paper gives no distance.
/// @param least  clusters of fewer points are noise and left out
/// @throws Error{bad_argument} for a distance that is not positive, or points that are not finite
[[nodiscard]] std::vector<Cluster> clusters_of(std::span<const Vec3> points, double distance_m = 3e-3,
                                               std::size_t least = 30);

/// How wide points are in a plane: the largest distance between two lines in it that hold them all, over 12 directions,
/// which is at most 1 % less than over all.
/// @param normal  of the plane, length 1
[[nodiscard]] double width_across(std::span<const Vec3> points, Vec3 normal);

/// The points of both, and their mean.
[[nodiscard]] Cluster together(const Cluster& a, const Cluster& b);

/// A finger as it is followed from shot to shot.
struct TrackedFinger {
    std::uint64_t id = 0;     ///< the same as long as it is followed, from 1
    Vec3 place;               ///< where it was seen last
    std::size_t cluster = 0;  ///< its number among this shot's clusters, when it is seen
    bool seen = true;         ///< false: missing in this shot, and given up if it is missing in the next one, too
};

/// Gives clusters their identity: each goes to the finger of the last shot that is nearest, the nearest pairs first.
/// The paper does not say how; this is ours.
class FingerTracker {
public:
    /// @param gate_m  a finger moves no farther between two shots
    /// @throws Error{bad_argument} when it is not positive
    explicit FingerTracker(double gate_m = 20e-3);
    /// @return the fingers in the order of their identities
    const std::vector<TrackedFinger>& update(const std::vector<Cluster>& clusters);

private:
    double gate_m_;
    std::uint64_t next_ = 1;
    std::vector<TrackedFinger> fingers_;
};

}  // namespace haptogram
