// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"

namespace haptogram {

/// How evenly points feel: statistics of the time-averaged radiation pressure at each.
struct Evenness {
    double spread = 0.0;   ///< standard deviation over mean
    double weakest = 0.0;  ///< the least, as Σ share·|p|², Pa²
};

/// What each focus makes at each of the points. Foci that lie near each other overlap, and an array is stronger near
/// its axis, so points that play for equal times do not feel equal; shares of the time can make up for that.
class CrossTalk {
public:
    static constexpr std::size_t most_points = 8192;  ///< the matrices then take 512 MiB

    /// Exact phases at full strength for every point, one after the other.
    /// @param points  metres, array frame
    /// @throws Error{bad_input} for more than most_points, or a point that coincides with an element or is out
    /// of every element's reach
    CrossTalk(const Array& array, std::span<const Vec3> points);

    /// The time-averaged |p|² at each point, Pa².
    /// @param shares  of the time, one a point
    [[nodiscard]] std::vector<double> felt(std::span<const double> shares) const;
    [[nodiscard]] Evenness evenness(std::span<const double> shares) const;

    /// Shares of the time that make all points feel more equal. With B the matrix of |p|², a round is
    /// w ← w ⊙ Bᵀ(1 ⊘ Bw) ⊘ Bᵀ1, the multiplicative iteration of Richardson (1972) and Lucy (1974) towards Bw = 1; the
    /// sum of the shares stays. After each round, a share below its floor is raised to it at the cost of the others.
    /// @param shares  to begin with
    /// @param floors  the least share of each point; their sum is at most that of the shares
    /// @param rounds  100 take most of the spread away, 1,000 nearly all that can be
    [[nodiscard]] std::vector<double> even_shares(std::span<const double> shares, std::span<const double> floors,
                                                  std::size_t rounds) const;

private:
    std::size_t count_ = 0, padded_ = 0;  ///< points, and rounded up to whole vectors
    /// |p|², 1 the largest: a row a point and a column a focus, and the other way round. 0 beyond the points.
    std::vector<float> at_points_, of_foci_;
    double scale_ = 1.0;  ///< Pa² that 1 stands for
};

}  // namespace haptogram
