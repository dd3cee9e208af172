// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <vector>

#include "haptogram/shape/shape.hpp"

namespace haptogram {

/// Straight lines from corner to corner, metres. A corner that repeats the one before it is left out.
/// @param closed  whether a last line leads back to the first corner
/// @throws Error{bad_argument} when fewer than two different corners are left, or one is not finite
[[nodiscard]] Curve polyline(const std::vector<Vec3>& corners, bool closed);

/// The same curve from its end to its beginning.
[[nodiscard]] Curve reversed(const Curve& curve);

/// The same closed curve, begun at the arc length `start`, metres.
/// @throws Error{bad_argument} when the curve is open and `start` is not 0
[[nodiscard]] Curve begun_at(const Curve& curve, double start);

/// How a curve of a list is drawn: from an arc length on when it is closed, or backwards when it is open.
struct CurveVisit {
    std::size_t curve = 0;  ///< its number in the list
    double start = 0.0;
    bool backwards = false;
};

/// Curves in the order in which a focus draws them, and how far it jumps between them.
struct CurveTour {
    std::vector<Curve> curves;
    std::vector<CurveVisit> visits;  ///< what each of them is of the list that was given
    double jumps_m = 0.0;  ///< all jumps of a pass, also that from the last curve's end to the first curve's beginning
};

/// An order with short jumps. Open curves may be drawn from either end; a closed curve may begin at any of 64 even
/// places. The nearest end comes next; then 2-opt moves and single moves shorten the jumps until none does. The same
/// curves give the same tour.
[[nodiscard]] CurveTour curve_tour(const std::vector<Curve>& curves);

}  // namespace haptogram
