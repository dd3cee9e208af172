// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/shape/draw.hpp"
#include "haptogram/verbs/compile.hpp"

using namespace haptogram;

namespace {

constexpr double carrier_hz = 40e3;

/// A project of one built-in shape in its usual place.
Project project_of(PrimitiveSpec spec, Pace pace, std::size_t points = 200) {
    Project project;
    ShapeSource source;
    source.primitive = std::move(spec);
    project.shapes = {source};
    project.pace = pace;
    project.points = points;
    return project;
}

/// What a listener to the image would see: where the focus is in each carrier period of a pass; no value in silence.
std::vector<std::optional<Vec3>> played(const Compiled& compiled) {
    std::vector<std::optional<Vec3>> periods;
    for (const SequenceEntry& entry : compiled.bundle.image.sequence) {
        std::optional<Vec3> where;
        if (entry.index > 0) where = compiled.bundle.manifest.records.at(entry.index - 1U).foci.front().position;
        periods.insert(periods.end(), entry.dwell, where);
    }
    return periods;
}

/// Length of the closed way from each place to the next.
double way(const std::vector<std::optional<Vec3>>& periods) {
    double sum = 0.0;
    for (std::size_t i = 0; i < periods.size(); ++i) sum += distance(*periods[i], *periods[(i + 1) % periods.size()]);
    return sum;
}

double jumps_of(const std::vector<Curve>& order) {
    double sum = 0.0;
    for (std::size_t i = 0; i < order.size(); ++i)
        sum += distance(order[i].at(order[i].length), order[(i + 1) % order.size()].at(0.0));
    return sum;
}

/// The least jumps of all orders and directions.
double least_jumps(const std::vector<Curve>& curves) {
    std::vector<std::size_t> order(curves.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    double least = std::numeric_limits<double>::infinity();
    do {
        for (unsigned directions = 0; directions < 1U << curves.size(); ++directions) {
            std::vector<Curve> drawn;
            for (const std::size_t i : order)
                drawn.push_back((directions >> i & 1U) != 0 ? reversed(curves[i]) : curves[i]);
            least = std::min(least, jumps_of(drawn));
        }
    } while (std::next_permutation(order.begin() + 1, order.end()));
    return least;
}

}  // namespace

TEST_CASE("curve: a polyline goes from corner to corner at its length", "[draw]") {
    const Curve open = polyline({{0, 0, 0}, {3, 0, 0}, {3, 0, 0}, {3, 4, 0}}, false);
    CHECK(open.length == Approx(7.0));
    CHECK(open.at(5.0) == Vec3{3, 2, 0});
    CHECK(reversed(open).at(1.0) == open.at(6.0));
    const Curve closed = polyline({{0, 0, 0}, {3, 0, 0}, {3, 4, 0}}, true);
    CHECK(closed.length == Approx(12.0));
    CHECK(distance(begun_at(closed, 3.0).at(10.0), closed.at(1.0)) < 1e-12);
    REQUIRE_REFUSED(begun_at(open, 1.0));
    REQUIRE_REFUSED(polyline({{1, 1, 1}, {1, 1, 1}}, false));
    REQUIRE_REFUSED(polyline({{1, 1, 1}, {1, NAN, 1}}, false));
}

TEST_CASE("curve: the tour of a few open curves is nearly as short as the best of all", "[draw]") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> place(-0.05, 0.05);
    double found = 0.0, best = 0.0;
    for (int round = 0; round < 30; ++round) {
        std::vector<Curve> curves;
        for (int i = 0; i < 5; ++i)
            curves.push_back(
                polyline({{place(random), place(random), 0.1}, {place(random), place(random), 0.1}}, false));
        const CurveTour tour = curve_tour(curves);
        REQUIRE(tour.curves.size() == curves.size());
        REQUIRE(tour.jumps_m == Approx(jumps_of(tour.curves)));
        for (const Curve& curve : curves)  // each is there once, whole
            REQUIRE(std::count_if(tour.curves.begin(), tour.curves.end(),
                                  [&](const Curve& drawn) { return drawn.length == curve.length; }) == 1);
        const double least = least_jumps(curves);
        REQUIRE(tour.jumps_m >= least - 1e-12);
        REQUIRE(tour.jumps_m <= 2.0 * least);
        found += tour.jumps_m;
        best += least;
    }
    REQUIRE(found <= 1.1 * best);
}

TEST_CASE("curve: a tour enters and leaves a ring where the next one is near", "[draw]") {
    std::vector<Curve> rings;
    for (const double x : {0.0, 0.03, 0.06}) {
        std::vector<Vec3> corners;
        for (int i = 0; i < 256; ++i)
            corners.push_back(
                {x + 0.01 * std::cos(std::numbers::pi * i / 128), 0.01 * std::sin(std::numbers::pi * i / 128), 0.1});
        rings.push_back(polyline(corners, true));
    }
    // There and back: 10 mm from ring to ring, then 60 mm less what the middle ring spares.
    const CurveTour tour = curve_tour(rings);
    REQUIRE(tour.jumps_m == Approx(jumps_of(tour.curves)));
    REQUIRE(tour.jumps_m <= 0.0801);
}

TEST_CASE("draw: the draw frequency at 7 m/s follows from the length", "[draw]") {
    // Length in mm and frequency in Hz: 7 m/s over the length.
    const auto [spec, hertz] = GENERATE(table<PrimitiveSpec, double>({
        {{.kind = "square", .length = 0.1}, 17.5},
        {{.kind = "circle", .diameter = 0.1}, 22.282},
        {{.kind = "circle", .diameter = 0.08}, 27.852},
        {{.kind = "circle", .diameter = 0.075}, 29.71},  // a cone of 100 mm, cut at a quarter of its height
        {{.kind = "circle", .diameter = 0.05}, 44.56},   // and in the middle
        {{.kind = "circle", .diameter = 0.025}, 89.13},
        {{.kind = "circle", .diameter = 0.04}, 55.70},
        {{.kind = "circle", .diameter = 0.02}, 111.4},
    }));
    const Compiled compiled = compile(project_of(spec, {usual_speed_m_s, {}}));
    REQUIRE(compiled.pace.has_value());
    // A pass is a whole number of carrier periods, so a frequency is off by half a period at most.
    REQUIRE(compiled.pace->frequency_hz == Approx(hertz).epsilon(0.5 * hertz / carrier_hz + 5e-5));
    REQUIRE(compiled.bundle.manifest.rate_hz == Approx(compiled.pace->frequency_hz));
}

TEST_CASE("draw: the measured speed is the asked one, and the spacing is even", "[draw]") {
    const double speed = GENERATE(0.5, 2.0, 7.0, 12.0);
    const std::size_t points = GENERATE(90, 200, 397);
    const double length = 0.06 * std::numbers::pi;
    if (carrier_hz * length / speed < static_cast<double>(points)) return;
    const Compiled compiled = compile(project_of({.kind = "circle", .diameter = 0.06}, {speed, {}}, points));
    const auto periods = played(compiled);
    const double measured = way(periods) * carrier_hz / static_cast<double>(periods.size());
    CAPTURE(speed, points, measured);
    REQUIRE(measured == Approx(speed).epsilon(0.005));
    REQUIRE(compiled.pace->speed_m_s == Approx(speed).epsilon(0.005));
    std::uint32_t least = 1000000, most = 0;
    const auto& sequence = compiled.bundle.image.sequence;
    REQUIRE(sequence.size() == points);
    for (std::size_t i = 0; i < points; ++i) {
        least = std::min<std::uint32_t>(least, sequence[i].dwell);
        most = std::max<std::uint32_t>(most, sequence[i].dwell);
        const Vec3 here = compiled.points.points[i], next = compiled.points.points[(i + 1) % points];
        REQUIRE(distance(here, next) == Approx(2 * 0.03 * std::sin(std::numbers::pi / static_cast<double>(points))));
    }
    REQUIRE(most - least <= 1);  // n and n + 1 carrier periods alternate
}

TEST_CASE("draw: a tenth of the usual speed is met within 1 %", "[draw]") {
    const auto periods = played(compile(project_of({.kind = "circle", .diameter = 0.1}, {0.7, {}})));
    REQUIRE(way(periods) * carrier_hz / static_cast<double>(periods.size()) == Approx(0.7).epsilon(0.01));
}

TEST_CASE("draw: one focus a carrier period is the fastest", "[draw]") {
    const double length = 0.02 * std::numbers::pi;
    const auto points = static_cast<std::size_t>(carrier_hz * length / 7.0);  // 359
    const Compiled compiled = compile(project_of({.kind = "circle", .diameter = 0.02}, {7.0, {}}, points));
    REQUIRE(points == 359);
    REQUIRE(compiled.bundle.image.sequence.size() == points);
    for (const SequenceEntry& entry : compiled.bundle.image.sequence) REQUIRE(entry.dwell == 1);
    REQUIRE_REFUSED(compile(project_of({.kind = "circle", .diameter = 0.02}, {7.0, {}}, points + 1)));
}

TEST_CASE("draw: jumps take no time, or silence for as long as the way", "[draw]") {
    for (const Jump jump : {Jump::hop, Jump::blank}) {
        Project project = project_of({.kind = "plus", .length = 0.1}, {5.0, {}});
        project.jump = jump;
        const auto periods = played(compile(project));
        const auto silent = std::count(periods.begin(), periods.end(), std::nullopt);
        // Two strokes of 100 mm; from tip to tip it is 70.71 mm, twice.
        const double gap_periods = 2 * 0.1 / std::sqrt(2.0) / 5.0 * carrier_hz;
        REQUIRE(static_cast<double>(silent) == (jump == Jump::hop ? Approx(0.0) : Approx(gap_periods).margin(1.5)));
        REQUIRE(static_cast<double>(periods.size()) - static_cast<double>(silent) ==
                Approx(0.2 / 5.0 * carrier_hz).margin(1.5));
    }
}

TEST_CASE("draw: each stroke of a plus is drawn from end to end", "[draw]") {
    const Compiled compiled = compile(project_of({.kind = "plus", .length = 0.1}, {{}, 10.0}, 100));
    const std::vector<Vec3>& points = compiled.points.points;
    REQUIRE(points.size() == 100);
    int hops = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        hops += distance(points[i], points[(i + 1) % points.size()]) > 2.01e-3 ? 1 : 0;
    REQUIRE(hops == 2);
    REQUIRE(compiled.pace->frequency_hz == Approx(10.0));
    REQUIRE(compiled.pace->speed_m_s == Approx(2.0));
}

TEST_CASE("draw: a surface is drawn along its tour", "[draw]") {
    const Compiled compiled = compile(project_of({.kind = "sphere", .diameter = 0.05}, {7.0, {}}, 50));
    REQUIRE(compiled.pace->length_m == Approx(compiled.points.tour_m));
    const auto periods = played(compiled);
    REQUIRE(way(periods) * carrier_hz / static_cast<double>(periods.size()) == Approx(7.0).epsilon(0.005));
}

TEST_CASE("draw: what is out of reach is passed over in silence, or refused", "[draw]") {
    Project project = project_of({.kind = "line", .length = 0.2}, {7.0, {}}, 100);
    project.placement.center = from_mm(120, 0, 60);
    REQUIRE_REFUSED(compile(project));
    project.clip = true;
    const Compiled compiled = compile(project);
    REQUIRE(compiled.points.clipped > 0);
    REQUIRE(compiled.points.clipped + compiled.points.points.size() == 100);
    const auto periods = played(compiled);
    REQUIRE(periods.size() == static_cast<std::size_t>(std::lround(0.2 / 7.0 * carrier_hz)));
    const auto silent = std::count(periods.begin(), periods.end(), std::nullopt);
    REQUIRE(static_cast<double>(silent) / static_cast<double>(periods.size()) ==
            Approx(static_cast<double>(compiled.points.clipped) / 100.0).margin(0.002));
}

TEST_CASE("draw: rounding to whole periods never runs ahead or behind by more than half of one", "[draw]") {
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> length(1.0, 9.0);
    std::vector<Stretch> stretches;
    for (int i = 0; i < 500; ++i) stretches.push_back({{{{0, 0, 0.1}}}, length(random)});
    const Path path = path_of(stretches);
    double exact = 0.0, whole = 0.0;
    for (std::size_t i = 0; i < stretches.size(); ++i) {
        exact += stretches[i].periods;
        whole += path.steps[i].periods;
        REQUIRE(std::abs(exact - whole) <= 0.5 + 1e-9);
    }
    REQUIRE_REFUSED(path_of({{{{{0, 0, 0.1}}}, 0.3}}));
}

TEST_CASE("draw: what makes no sense is named", "[draw]") {
    REQUIRE_REFUSED(compile(project_of({.kind = "point"}, {7.0, {}})));
    REQUIRE_REFUSED(compile(project_of({.kind = "circle"}, {7.0, 10.0})));
    REQUIRE_REFUSED(compile(project_of({.kind = "circle"}, {-1.0, {}})));
    REQUIRE_REFUSED(compile(project_of({.kind = "plus"}, {1.0, {}}, 1)));
    REQUIRE_REFUSED(compile(project_of({.kind = "circle"}, {1.0, {}}, 500)));
}

TEST_CASE("draw: project files have speed, frequency and jump", "[draw][project]") {
    const std::string head = "format = \"haptogram-project-1\"\n", shape = "[[shape]]\nkind = \"plus\"\n";
    const Project project = project_from_toml(head + "speed_m_s = 7\njump = \"blank\"\n" + shape, "p.toml");
    REQUIRE(project.pace.speed_m_s == 7.0);
    REQUIRE(project.jump == Jump::blank);
    REQUIRE(to_toml(project_from_toml(to_toml(project), "p.toml")) == to_toml(project));
    REQUIRE(project_from_toml(head + "frequency_hz = 12.5\n" + shape, "p.toml").pace.frequency_hz == 12.5);
    REQUIRE_REFUSED(project_from_toml(head + "rate_hz = 10\nspeed_m_s = 7\n" + shape, "p.toml"));
    REQUIRE_REFUSED(project_from_toml(head + "jump = \"leap\"\n" + shape, "p.toml"));
}
