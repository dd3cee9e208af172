// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "haptogram/array/vec3.hpp"
#include "haptogram/live/depth.hpp"

namespace haptogram {

/// How depth becomes points (Fingers, section 3, "Hand sensing"). The paper gives the order of the steps and the grid
/// of 0.5 mm; the other numbers are ours.
struct CloudOptions {
    Vec3 low{-0.15, -0.15, 0.02};  ///< the workspace: whatever is outside this box, array frame, is background
    Vec3 high{0.15, 0.15, 0.32};
    std::uint32_t window_px = 5;  ///< of the bilateral filter, odd; 1: no filter
    double space_px = 2.0;        ///< its standard deviation in the picture
    double depth_m = 5e-3;        ///< and in depth; from four of them on, a neighbour counts nothing
    double cell_m = 0.5e-3;       ///< of the voxel grid; 0: every pixel stays a point
};

/// Makes clouds of points from shots. It keeps the pictures' memory and the filter's tables between shots.
class CloudMaker {
public:
    /// @throws Error{bad_argument} naming an option that makes no sense
    explicit CloudMaker(const CloudOptions& options);

    /// The points of one picture, metres, array frame, row by row: the pixels in the workspace, filtered among
    /// themselves, and reprojected. Background and pixels that were not seen do not reach into the filter.
    /// @throws Error{bad_argument} when the picture has not the camera's size
    [[nodiscard]] std::vector<Vec3> points(const DepthCamera& camera, const DepthPicture& picture);

    /// The points of all pictures of a shot, one in each cell of the grid that has any: their mean.
    /// @throws Error{bad_argument} when there are not as many pictures as cameras
    [[nodiscard]] std::vector<Vec3> cloud(std::span<const DepthCamera> cameras, const DepthShot& shot);

private:
    void cut_out(const DepthCamera& camera, const DepthPicture& picture);
    void prepare_weights(double unit_m);
    [[nodiscard]] float filtered(std::size_t at) const;

    CloudOptions options_;
    std::uint32_t reach_;               ///< of the filter, pixels to either side
    std::vector<std::uint16_t> kept_;   ///< the picture without background, with a margin as wide as the reach
    std::size_t stride_ = 0;            ///< of its rows
    std::vector<std::size_t> pixels_;   ///< places in kept_ that are not background
    std::vector<float> space_weights_;  ///< by place in the window
    std::vector<float> depth_weights_;  ///< by counts between two pixels; the last one is 0
    double weights_unit_m_ = 0.0;       ///< for which depth_weights_ are
};

/// The mean of the points in each cell of a grid that has any, in the order of cells: by x, then y, then z.
/// @param cell_m  edge; cell borders are at its multiples
/// @throws Error{bad_argument} when it is not positive, when a point is not finite, or when the points lie more than
/// 2^20 cells apart
[[nodiscard]] std::vector<Vec3> voxel_grid(std::span<const Vec3> points, double cell_m);

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
