// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/draw.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/tour.hpp"

namespace haptogram {
namespace {

/// One way to draw a curve, with where the focus enters and where it leaves.
struct Visit : CurveVisit {
    Vec3 entry, exit;
};

using Ways = std::vector<Visit>;

Ways ways_through(const Curve& curve, std::size_t number) {
    constexpr int places = 64;
    if (!curve.closed) {
        const Vec3 begin = curve.at(0.0);
        const Vec3 end = curve.at(curve.length);
        return {{{number, 0.0, false}, begin, end}, {{number, 0.0, true}, end, begin}};
    }
    Ways ways;
    for (int i = 0; i < places; ++i) {
        const double start = curve.length * i / places;
        const Vec3 place = curve.at(start);
        ways.push_back({{number, start, false}, place, place});
    }
    return ways;
}

/// The same visit when the round is walked the other way. A closed curve keeps its direction.
Visit turned(Visit visit) {
    if (visit.entry == visit.exit) return visit;
    visit.backwards = !visit.backwards;
    std::swap(visit.entry, visit.exit);
    return visit;
}

/// A closed round of visits, made shorter by moves that each shorten it.
class Round {
public:
    explicit Round(const std::vector<Ways>& ways) : ways_(ways) {
        std::vector<bool> visited(ways.size());
        visits_.push_back(ways.front().front());
        visited[0] = true;
        while (visits_.size() < ways.size()) {
            const Vec3 here = visits_.back().exit;
            const Visit* nearest = nullptr;
            for (std::size_t i = 0; i < ways.size(); ++i) {
                if (visited[i]) continue;
                for (const Visit& way : ways[i])
                    if (nearest == nullptr || distance(here, way.entry) < distance(here, nearest->entry))
                        nearest = &way;
            }
            visited[nearest->curve] = true;
            visits_.push_back(*nearest);
        }
    }

    void shorten() {
        while (choose_ways() || turn_runs() || move_single()) {
        }
    }

    [[nodiscard]] const std::vector<Visit>& visits() const { return visits_; }

    [[nodiscard]] double jumps() const {
        double sum = 0.0;
        for (std::size_t i = 0; i < visits_.size(); ++i) sum += distance(visits_[i].exit, next(i).entry);
        return sum;
    }

private:
    static constexpr double least_gain_m = 1e-9;  // rounding must not go round in circles

    [[nodiscard]] const Visit& next(std::size_t i) const { return visits_[(i + 1) % visits_.size()]; }
    [[nodiscard]] const Visit& last(std::size_t i) const { return visits_[(i + visits_.size() - 1) % visits_.size()]; }

    bool choose_ways() {
        bool shorter = false;
        for (std::size_t i = 0; i < visits_.size() && visits_.size() > 1; ++i) {
            const auto cost = [&](const Visit& way) {
                return distance(last(i).exit, way.entry) + distance(way.exit, next(i).entry);
            };
            for (const Visit& way : ways_[visits_[i].curve]) {
                if (cost(way) > cost(visits_[i]) - least_gain_m) continue;
                visits_[i] = way;
                shorter = true;
            }
        }
        return shorter;
    }

    /// 2-opt: a run of visits the other way round.
    bool turn_runs() {
        for (std::size_t i = 0; i + 1 < visits_.size(); ++i) {
            for (std::size_t j = i + 1; j < visits_.size(); ++j) {
                if (i == 0 && j + 1 == visits_.size()) continue;  // the whole round
                const double before =
                    distance(last(i).exit, visits_[i].entry) + distance(visits_[j].exit, next(j).entry);
                const double after =
                    distance(last(i).exit, visits_[j].exit) + distance(visits_[i].entry, next(j).entry);
                if (after > before - least_gain_m) continue;
                const auto begin = visits_.begin();
                std::reverse(begin + static_cast<std::ptrdiff_t>(i), begin + static_cast<std::ptrdiff_t>(j) + 1);
                for (std::size_t k = i; k <= j; ++k) visits_[k] = turned(visits_[k]);
                return true;
            }
        }
        return false;
    }

    /// One visit to another place of the round.
    bool move_single() {
        const double before = jumps();
        for (std::size_t from = 0; from < visits_.size() && visits_.size() > 2; ++from) {
            const std::vector<Visit> kept = visits_;
            const Visit moved = visits_[from];
            const double saved = distance(last(from).exit, moved.entry) + distance(moved.exit, next(from).entry) -
                                 distance(last(from).exit, next(from).entry);
            visits_.erase(visits_.begin() + static_cast<std::ptrdiff_t>(from));
            for (std::size_t to = 0; to < visits_.size(); ++to) {
                const Vec3 left = visits_[to].exit;
                const Vec3 entered = next(to).entry;
                for (const Visit& way : ways_[moved.curve]) {
                    const double added =
                        distance(left, way.entry) + distance(way.exit, entered) - distance(left, entered);
                    if (added > saved - least_gain_m) continue;
                    visits_.insert(visits_.begin() + static_cast<std::ptrdiff_t>(to) + 1, way);
                    if (jumps() < before) return true;
                    visits_.erase(visits_.begin() + static_cast<std::ptrdiff_t>(to) + 1);
                }
            }
            visits_ = kept;
        }
        return false;
    }

    const std::vector<Ways>& ways_;
    std::vector<Visit> visits_;
};

}  // namespace

Curve polyline(const std::vector<Vec3>& corners, bool closed) {
    std::vector<Vec3> kept;
    for (const Vec3& corner : corners) {
        if (!is_finite(corner)) throw bad_argument("polyline", "a corner is not finite; correct it");
        if (kept.empty() || corner != kept.back()) kept.push_back(corner);
    }
    if (closed && !kept.empty() && kept.back() != kept.front()) kept.push_back(kept.front());
    if (kept.size() < 2)
        throw bad_argument("polyline", "it has fewer than two different corners; give it two at least");
    std::vector<double> until{0.0};  // arc length up to each corner
    for (std::size_t i = 1; i < kept.size(); ++i) until.push_back(until.back() + distance(kept[i - 1], kept[i]));
    const double length = until.back();
    const auto at = [kept = std::move(kept), until = std::move(until)](double s) {
        const auto after = std::upper_bound(until.begin() + 1, until.end() - 1, s);
        const auto i = static_cast<std::size_t>(after - until.begin());
        return kept[i - 1] + (s - until[i - 1]) / (until[i] - until[i - 1]) * (kept[i] - kept[i - 1]);
    };
    return {at, length, closed};
}

Curve reversed(const Curve& curve) {
    return {[curve](double s) { return curve.at(curve.length - s); }, curve.length, curve.closed};
}

Curve begun_at(const Curve& curve, double start) {
    if (start == 0.0) return curve;
    if (!curve.closed) throw bad_argument("start", "an open curve begins at its end points only");
    return {[curve, start](double s) { return curve.at(std::fmod(start + s, curve.length)); }, curve.length, true};
}

CurveTour curve_tour(const std::vector<Curve>& curves) {
    CurveTour tour;
    if (curves.empty()) return tour;
    std::vector<Ways> ways;
    for (const Curve& curve : curves) ways.push_back(ways_through(curve, ways.size()));
    Round round(ways);
    round.shorten();
    for (const Visit& visit : round.visits()) {
        const Curve& curve = curves[visit.curve];
        tour.visits.push_back(visit);
        tour.curves.push_back(visit.backwards ? reversed(curve) : begun_at(curve, visit.start));
    }
    tour.jumps_m = round.jumps();
    return tour;
}

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
