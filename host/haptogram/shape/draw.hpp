// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "haptogram/format/path.hpp"
#include "haptogram/shape/shape.hpp"
#include "haptogram/shape/shape_path.hpp"

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

/// What happens between the end of one curve and the beginning of the next.
enum class Jump {
    hop,    ///< the focus is there at once; the jump takes no time
    blank,  ///< silence, for as long as the focus would take at its speed
};

/// How fast a focus draws. Exactly one of the two is given.
struct Pace {
    std::optional<double> speed_m_s;     ///< along the curves
    std::optional<double> frequency_hz;  ///< passes over all curves a second
};

/// The speed at which focal points that follow a line are felt best by a rule of thumb of the paper “Shapes”, m/s.
inline constexpr double usual_speed_m_s = 7.0;

/// A part of a pass: foci, or silence, and its carrier periods, a number that need not be whole.
struct Stretch {
    std::vector<Focus> foci;
    double periods = 0.0;
    bool mark = false;  ///< its beginning is told at a board's trigger output
};

/// A pass over curves: what plays one after the other, and the numbers that describe it.
struct Drawing {
    std::vector<Stretch> stretches;
    TouredPoints points;       ///< their points alone, in the same order
    double length_m = 0.0;     ///< of what is drawn
    double jumps_m = 0.0;      ///< of the jumps between the curves
    double spacing_m = 0.0;    ///< the mean way along the curves from one point to the next
    double travelled_m = 0.0;  ///< by the focus in one pass: the length, and the jumps when they take time
};

/// Points along curves, each for the time that the focus takes for its part of the curve, so that the focus moves at
/// one speed. The curves get points by their lengths, at least one each. A point stands in the middle of its part. With
/// the speed v and the carrier f, a pass takes f·L/v carrier periods, where L is the way that the focus travels.
/// @param options  its `points` are those of all curves together
/// @throws Error{bad_argument} unless the pace has exactly one positive number; Error{bad_input} when a point would
/// last less than a carrier period, or there are fewer points than curves, or points out of reach, or too many
[[nodiscard]] Drawing drawing_of(const CurveTour& tour, const Array& array, double carrier_hz, const Pace& pace,
                                 Jump jump, const ShapePathOptions& options);

/// The same for points in the order of a tour: the focus stays for the same time at each.
[[nodiscard]] Drawing drawing_of(TouredPoints points, double carrier_hz, const Pace& pace);

/// Rounds the stretches to whole carrier periods. What rounding takes from one stretch it gives to the next, so that
/// dwells of n and n + 1 periods alternate where they must, and no point comes more than half a period early or late.
/// @throws Error{bad_input} when a focus would get no period at all
[[nodiscard]] Path path_of(const std::vector<Stretch>& stretches);

}  // namespace haptogram
