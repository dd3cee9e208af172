// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/draw.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/sample.hpp"

namespace haptogram {
namespace {

void require_pace(const Pace& pace) {
    if (pace.speed_m_s.has_value() == pace.frequency_hz.has_value())
        throw bad_argument("speed", "give either a speed or a frequency", {"speed", "frequency"});
    require_positive(pace.speed_m_s ? "speed" : "frequency", pace.speed_m_s ? *pace.speed_m_s : *pace.frequency_hz);
}

/// Carrier periods in which the focus travels a metre.
double periods_per_metre(const Pace& pace, double carrier_hz, double travelled_m) {
    return pace.speed_m_s ? carrier_hz / *pace.speed_m_s : carrier_hz / (*pace.frequency_hz * travelled_m);
}

void require_whole_periods(double drawn_periods, std::size_t points, const Pace& pace) {
    const double each = drawn_periods / static_cast<double>(points);
    // A rounding error of the division is no reason to refuse one point a period.
    if (each >= 1.0 - 1e-9) return;
    const double asked = pace.speed_m_s ? *pace.speed_m_s : *pace.frequency_hz;
    const char* const unit = pace.speed_m_s ? "m/s" : "Hz";
    throw impossible(
        pace.speed_m_s ? "speed" : "frequency",
        fmt::format("{} points at {:.6g} {} leave {:.3f} carrier periods a point, and a focus lasts at least one; take "
                    "at most {} points, or {:.4g} {}",
                    points, asked, unit, each, static_cast<std::size_t>(drawn_periods + 1e-9), asked * each, unit),
        {"points"});
}

double length_of(const std::vector<Curve>& curves) {
    return std::accumulate(curves.begin(), curves.end(), 0.0,
                           [](double sum, const Curve& curve) { return sum + curve.length; });
}

}  // namespace

Drawing drawing_of(const CurveTour& tour, const Array& array, double carrier_hz, const Pace& pace, Jump jump,
                   const ShapePathOptions& options) {
    require_pace(pace);
    const std::vector<Curve>& curves = tour.curves;
    if (curves.empty()) throw bad_argument("shape", "there are no curves to draw", {"shape"});
    if (options.points < curves.size())
        throw impossible("points", fmt::format("{} points for {} curves; every curve takes at least one",
                                               options.points, curves.size()));
    Drawing drawing;
    drawing.length_m = length_of(curves);
    drawing.jumps_m = tour.jumps_m;
    drawing.spacing_m = drawing.length_m / static_cast<double>(options.points);
    drawing.travelled_m = drawing.length_m + (jump == Jump::blank ? tour.jumps_m : 0.0);
    const double per_metre = periods_per_metre(pace, carrier_hz, drawing.travelled_m);
    require_whole_periods(drawing.length_m * per_metre, options.points, pace);

    // One point a curve, and the others by their lengths.
    std::vector<double> lengths;
    for (const Curve& curve : curves) lengths.push_back(curve.length);
    const std::vector<std::size_t> shares = share(options.points - curves.size(), lengths);
    std::vector<Vec3> points;
    for (std::size_t c = 0; c < curves.size(); ++c) {
        const std::size_t count = shares[c] + 1;
        const double part = curves[c].length / static_cast<double>(count);
        for (std::size_t i = 0; i < count; ++i) {
            points.push_back(curves[c].at(part * (static_cast<double>(i) + 0.5)));
            drawing.stretches.push_back({{{points.back()}}, part * per_metre});
        }
        if (jump == Jump::hop) continue;
        const Vec3 left = curves[c].at(curves[c].length);
        const Vec3 entered = curves[(c + 1) % curves.size()].at(0.0);
        const double gap = distance(left, entered);
        if (gap > 0.0 && !(curves.size() == 1 && curves[c].closed)) drawing.stretches.push_back({{}, gap * per_metre});
    }
    const std::vector<std::size_t> reachable = reachable_points(points, array, options.clip);
    require_room(reachable.size(), options);
    drawing.points.clipped = points.size() - reachable.size();
    for (const std::size_t i : reachable) drawing.points.points.push_back(points[i]);
    if (drawing.points.clipped > 0) {
        // What is left out is passed over in silence, so that the rest keeps its speed and the pass its frequency.
        std::size_t next = 0, number = 0;
        for (Stretch& stretch : drawing.stretches) {
            if (stretch.foci.empty()) continue;
            if (next < reachable.size() && reachable[next] == number)
                ++next;
            else
                stretch.foci.clear();
            ++number;
        }
    }
    drawing.points.tour_m = drawing.length_m + tour.jumps_m;
    drawing.points.as_given_m = drawing.points.tour_m;
    return drawing;
}

Drawing drawing_of(TouredPoints points, double carrier_hz, const Pace& pace) {
    require_pace(pace);
    Drawing drawing;
    const std::size_t count = points.points.size();
    drawing.length_m = drawing.travelled_m = points.tour_m;
    drawing.spacing_m = points.tour_m / static_cast<double>(count);
    if (pace.speed_m_s && drawing.length_m == 0.0)
        throw impossible("speed",
                         "all of the shape is one point, and a focus that does not move has no speed; "
                         "give a frequency or a rate",
                         {"frequency", "rate"});
    const double periods = pace.frequency_hz ? carrier_hz / *pace.frequency_hz
                                             : drawing.length_m * periods_per_metre(pace, carrier_hz, drawing.length_m);
    require_whole_periods(periods, count, pace);
    for (const Vec3& point : points.points)
        drawing.stretches.push_back({{{point}}, periods / static_cast<double>(count)});
    drawing.points = std::move(points);
    return drawing;
}

Path path_of(const std::vector<Stretch>& stretches) {
    Path path;
    double exact = 0.0;
    std::uint64_t given = 0;
    for (const Stretch& stretch : stretches) {
        exact += stretch.periods;
        const auto until = static_cast<std::uint64_t>(std::llround(exact));
        const std::uint64_t periods = until - given;
        given = until;
        constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
        if (periods > most)
            throw impossible("rate",
                             fmt::format("a point lasts {} carrier periods; expected at most {}", periods, most));
        if (periods == 0) {
            if (stretch.foci.empty()) continue;  // silence of less than half a period
            throw impossible("rate",
                             fmt::format("a focus lasts {:.3f} carrier periods, which leaves it none after rounding; "
                                         "take fewer points, or a lower speed, frequency or rate",
                                         stretch.periods),
                             {"points"});
        }
        path.steps.push_back({stretch.foci, static_cast<std::uint32_t>(periods), stretch.mark});
    }
    return path;
}

}  // namespace haptogram
