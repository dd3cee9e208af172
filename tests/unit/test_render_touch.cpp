// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string_view>
#include <vector>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/hand/recording.hpp"
#include "haptogram/hand/render.hpp"
#include "haptogram/solve/solver.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double carrier_hz = 40e3;

std::vector<SkinRegion> plane_at(double z) {
    Hand hand;
    hand.palm = {0, 0, z};
    SkinOptions options;
    options.palm_width_m = options.palm_length_m = 0.12;
    return palmar_surface(hand, options);
}

HandRecording one_frame(const Hand& hand) { return {{{0.0, {hand}}}}; }

std::vector<const SkinLine*> of_kind(const Touch& made, LineKind kind) {
    std::vector<const SkinLine*> lines;
    for (const SkinLine& line : made.lines)
        if (line.kind == kind) lines.push_back(&line);
    return lines;
}

ObjectMeasures measures_of(double size, Vec3 centre) {
    ObjectMeasures measures;
    measures.size = measures.height = size;
    measures.centre = centre;
    return measures;
}

/// 16 × 16 point sources 165/16 mm apart, as in the papers Shapes and Multimodal.
Array point_sources() {
    Array array = find_array("tile-10x10");
    array.elements.clear();
    array.columns = 16;
    for (int row = 0; row < 16; ++row)
        for (int column = 0; column < 16; ++column)
            array.elements.push_back({from_mm((column - 7.5) * 10.3125, (row - 7.5) * 10.3125, 0.0)});
    array.transducer.radius_m = 0.0;
    array.medium.absorption_np_m = 0.0;
    array.medium.speed_m_s = 343.2;
    return array;
}

}  // namespace

TEST_CASE("features: edges are clipped to the hand's boxes, and corners get their figure", "[render]") {
    // The top of the cube, 60 × 60 mm, is 5 mm above the palm's plane and inside its box.
    const TouchObject cube = built_in_object("cube", measures_of(0.06, {0, 0, 0.175}));
    const auto skin = plane_at(0.2);
    FeatureOptions options;
    options.corner = CornerFigure::circle;
    const std::vector<SkinLine> lines = feature_lines(cube, skin, 0.0, options);
    double edges = 0.0;
    std::size_t circles = 0, stubs = 0;
    for (const SkinLine& line : lines) {
        REQUIRE(line.kind == LineKind::feature);
        for (const SkinPoint& point : line.points) REQUIRE(point.position.z == Approx(0.2));
        if (line.closed) {
            ++circles;
            CHECK(length_of(line) == Approx(2 * pi * 5e-3).epsilon(0.002));
        } else if (length_of(line) < 1e-9) {
            ++stubs;  // an edge at right angles to the skin is a point on it (Shapes, section V)
        } else {
            edges += length_of(line);
        }
    }
    CHECK(circles == 4);
    CHECK(stubs == 4);
    CHECK(edges == Approx(4 * 0.06).epsilon(1e-9));
    // Off the skin the edges stay where they are: upright ones have the length that is in the box, 12.5 + 5 mm.
    options.project = false;
    double upright = 0.0;
    for (const SkinLine& line : feature_lines(cube, skin, 0.0, options))
        if (!line.closed && std::abs(line.points[0].position.z - line.points[1].position.z) > 1e-6)
            upright += length_of(line);
    CHECK(upright == Approx(4 * 0.0175).epsilon(1e-9));
    // A hand elsewhere has none.
    CHECK(feature_lines(cube, plane_at(0.3), 0.0, options).empty());
}

TEST_CASE("features: the five figures of a corner have their size and move as they are named", "[render]") {
    const TouchObject cone = built_in_object("cone", measures_of(0.1, {0, 0, 0.15}));  // its tip is at 200 mm
    const auto skin = plane_at(0.2);
    FeatureOptions options;
    const auto tip = [&](CornerFigure figure, double time_s) {
        options.corner = figure;
        const auto lines = feature_lines(cone, skin, time_s, options);
        REQUIRE(lines.size() == 1);
        return lines.front();
    };
    for (const SkinPoint& p : tip(CornerFigure::circle, 0.3).points)
        CHECK(distance(p.position, {0, 0, 0.2}) == Approx(5e-3));
    CHECK(distance(tip(CornerFigure::pulsing, 0.05).points[0].position, {0, 0, 0.2}) == Approx(7.5e-3));
    CHECK(distance(tip(CornerFigure::pulsing, 0.15).points[0].position, {0, 0, 0.2}) == Approx(2.5e-3));
    const SkinLine line = tip(CornerFigure::line, 0.0), turned = tip(CornerFigure::line, 0.0125);
    CHECK(length_of(line) == Approx(10e-3));
    const Vec3 a = line.points[1].position - line.points[0].position,
               b = turned.points[1].position - turned.points[0].position;
    CHECK(dot(a, b) == Approx(0.0).margin(1e-9));  // a quarter turn at 20 a second
    CHECK(length_of(tip(CornerFigure::triangle, 0.0)) == Approx(30e-3));
    const SkinLine points = tip(CornerFigure::points, 0.0), others = tip(CornerFigure::points, 0.01);
    REQUIRE(points.points.size() == 8);
    CHECK(points.points[0].position != others.points[0].position);
    for (const SkinPoint& p : points.points) CHECK(distance(p.position, {0, 0, 0.2}) <= 5e-3);
    CHECK(corner_figure("rotating-line") == CornerFigure::line);
    REQUIRE_REFUSED(corner_figure("star"));
}

TEST_CASE("algorithms: what each draws on a plane in a sphere", "[render]") {
    // A sphere of 50 mm radius that a plane cuts 30 mm above its centre: a circle of 40 mm, and 20 mm at most deep.
    const TouchObject sphere = built_in_object("sphere", {});
    const auto skin = plane_at(0.23);
    const auto made = [&](char letter, TouchOptions options = {}) {
        return touch_of(algorithm_of(std::string(1, letter)), sphere, skin, 0.0, options);
    };
    const double circle = 2 * pi * 0.04;
    CHECK(made('B').voices.empty());
    const Touch c = made('C');
    REQUIRE(c.voices.size() == 2);
    CHECK(length_of(c.lines) == Approx(circle).epsilon(0.002));
    CHECK(c.voices[1].am_hz == 200.0);
    CHECK(distance(c.voices[1].legs.at(0).from.position, {0, 0, 0.23}) < 1e-3);
    // D: the depth in the plane is 50 mm − √(r² + 30²), so 16 mm deep is a circle of √(34² − 30²) = 16 mm.
    const Touch d = made('D');
    REQUIRE(d.voices.size() == 1);
    CHECK(length_of(d.lines) == Approx(circle + 2 * pi * 0.016).epsilon(0.003));
    TouchOptions two;
    two.two_foci = true;
    CHECK(made('D', two).voices.size() == 2);
    // E and F: a line of 4 mm for each 6 × 6 mm of the disc, to about a row of squares around its rim.
    const double squares = pi * 0.04 * 0.04 / 36e-6;
    for (const char letter : {'E', 'F'}) {
        CAPTURE(letter);
        const Touch grain = made(letter);
        CHECK(static_cast<double>(grain.lines.size()) == Approx(squares).epsilon(letter == 'E' ? 0.1 : 0.35));
        for (const SkinLine& line : grain.lines) {
            REQUIRE(line.points.size() == 5);
            REQUIRE(length_of(line) == Approx(4e-3).epsilon(1e-6));
        }
        const Touch later = touch_of(algorithm_of(std::string(1, letter)), sphere, skin, 0.01, {});
        const bool same = later.lines.size() == grain.lines.size() &&
                          later.lines.front().points[2].position == grain.lines.front().points[2].position;
        CHECK(same == (letter == 'F'));
    }
    // G: 20 mm deep, and no more than 25 mm wide.
    const Touch g = made('G');
    REQUIRE(g.lines.size() == 1);
    CHECK(length_of(g.lines) == Approx(2 * pi * 0.025).epsilon(0.002));
    TouchOptions wide;
    wide.blob_palm_m = 1.0;
    CHECK(length_of(made('G', wide).lines) == Approx(2 * pi * 0.04).epsilon(0.002));
    // A sphere has no features, so H, I and J are A, D and G.
    for (const auto& [mixed, plain] : {std::pair('H', 'A'), {'I', 'D'}, {'J', 'G'}})
        CHECK(length_of(made(mixed).lines) == Approx(length_of(made(plain).lines)));
    // K goes along the outline at 0.1 m/s and never waits, as a circle has no corners.
    const Touch k = made('K');
    CHECK(k.am_hz == 200.0);
    CHECK(k.voices.at(0).seconds() == Approx(circle / 0.1).epsilon(0.003));
    // L: four foci a quarter of a circle of 3 mm apart, five turns a second.
    const Touch l = made('L');
    REQUIRE(l.voices.size() == 4);
    Vec3 middle;
    for (const Voice& voice : l.voices) middle = middle + 0.25 * voice.legs.at(0).from.position;
    CHECK(distance(middle, {0, 0, 0.23}) < 1e-3);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK(l.voices[i].seconds() == Approx(0.2));
        const Vec3 at = l.voices[i].legs.at(0).from.position, next = l.voices[(i + 1) % 4].legs.at(0).from.position;
        CHECK(distance(at, middle) == Approx(3e-3));
        CHECK(distance(at, next) == Approx(3e-3 * std::numbers::sqrt2));
    }
    REQUIRE_REFUSED(algorithm_of("M"));
    CHECK(algorithm_of("h") == Algorithm::features_intersection);
}

TEST_CASE("algorithms: a pointer waits at the corners of a square", "[render]") {
    const TouchObject cube = built_in_object("cube", measures_of(0.06, {0, 0, 0.2}));
    const Touch made = touch_of(Algorithm::pointer, cube, plane_at(0.2));
    std::vector<Vec3> stops;
    double waited = 0.0;
    for (const Leg& leg : made.voices.at(0).legs)
        if (leg.from.position == leg.to.position) {
            stops.push_back(leg.from.position);
            waited += leg.seconds;
        }
    REQUIRE(stops.size() == 4);
    CHECK(waited == Approx(4 * 0.3));
    for (const Vec3& stop : stops) {
        CHECK(std::abs(stop.x) == Approx(0.03).margin(1.1e-3));
        CHECK(std::abs(stop.y) == Approx(0.03).margin(1.1e-3));
    }
    CHECK(made.voices.at(0).seconds() == Approx(1.2 + 0.24 / 0.1).epsilon(0.02));
}

TEST_CASE("algorithms: other lines keep the gap from features, or leave the finger", "[render]") {
    const TouchObject cube = built_in_object("cube", measures_of(0.1, {0.0, 0.03, 0.2}));
    const auto skin = palmar_surface(synthetic_hand(HandScript::slide, 0.6, 0.245));
    TouchOptions options;
    options.gap_m = GENERATE(4e-3, 10e-3);
    for (const Algorithm algorithm :
         {Algorithm::features_intersection, Algorithm::features_solid, Algorithm::features_blobs}) {
        const Touch made = touch_of(algorithm, cube, skin, 0.0, options);
        std::vector<SkinLine> features, others;
        for (const SkinLine& line : made.lines) (line.kind == LineKind::feature ? features : others).push_back(line);
        REQUIRE_FALSE(features.empty());
        const std::vector<Vec3> near = points_along(features, 0.2e-3);
        double nearest = INFINITY;
        for (const Vec3& p : points_along(others, 0.2e-3))
            for (const Vec3& q : near) nearest = std::min(nearest, distance(p, q));
        REQUIRE(nearest > options.gap_m - 0.3e-3);
    }
    // Without a gap nothing is lost; with one no more than is near.
    const auto length = [&](double gap_m) {
        TouchOptions some;
        some.gap_m = gap_m;
        return length_of(touch_of(Algorithm::features_intersection, cube, skin, 0.0, some).lines);
    };
    const double a = length_of(touch_of(Algorithm::intersection, cube, skin).lines),
                 b = length_of(touch_of(Algorithm::features, cube, skin).lines);
    CHECK(length(0.0) == Approx(a + b));
    CHECK(length(5e-3) < length(0.0));
    CHECK(length(20e-3) <= length(5e-3));
    options.priority = Priority::finger;
    const Touch made = touch_of(Algorithm::features_intersection, cube, skin, 0.0, options);
    for (const SkinLine* feature : of_kind(made, LineKind::feature))
        for (const SkinLine* contour : of_kind(made, LineKind::contour)) REQUIRE(feature->region != contour->region);
}

TEST_CASE("algorithms: their lengths have the order that Shapes felt", "[render]") {
    ObjectMeasures measures = measures_of(0.08, {0, 0, 0.15});
    measures.height = 0.04;
    const TouchObject pyramid = built_in_object("pyramid", measures);
    const auto skin = palmar_surface(synthetic_hand(HandScript::press, 0.29, 0.15));
    const auto length = [&](Algorithm algorithm) { return length_of(touch_of(algorithm, pyramid, skin).lines); };
    const double a = length(Algorithm::intersection), h = length(Algorithm::features_intersection);
    CHECK(length(Algorithm::features) < a);
    CHECK(h == Approx(a).epsilon(0.15));
    CHECK(std::max(a, h) < length(Algorithm::solid));
    CHECK(h < length(Algorithm::features_solid));
    CHECK(length(Algorithm::blobs) < length(Algorithm::features_blobs));
}

TEST_CASE("lines: the gap rule cuts where the distance is the gap", "[render]") {
    SkinLine ring{{}, true, LineKind::contour, 3};
    for (int i = 0; i < 720; ++i)
        ring.points.push_back(
            {{0.03 * std::cos(2 * pi * i / 720), 0.03 * std::sin(2 * pi * i / 720), 0.2}, {0, 0, -1}});
    // A point on the ring, where the list of points begins and ends, takes an arc with the chord of 10 mm on either
    // side.
    const auto left = away_from({ring}, {{0.03, 0, 0.2}}, 0.01);
    REQUIRE(left.size() == 1);
    CHECK_FALSE(left[0].closed);
    CHECK(left[0].region == 3);
    CHECK(length_of(left) == Approx(0.03 * (2 * pi - 4 * std::asin(0.005 / 0.03))).epsilon(1e-4));
    // On the other side the run goes across the beginning of the list and stays one.
    CHECK(away_from({ring}, {{-0.03, 0, 0.2}}, 0.01).size() == 1);
    CHECK(away_from({ring}, {{0, 0.03, 0.2}, {0, -0.03, 0.2}}, 0.01).size() == 2);
    CHECK(away_from({ring}, {{0, 0, 0.2}}, 0.031).empty());
    CHECK(away_from({ring}, {}, 0.01).at(0).closed);
}

TEST_CASE("render: the focus moves at the speed, in steps that differ by one period at most", "[render]") {
    const TouchObject sphere = built_in_object("sphere", measures_of(0.08, {0, 0, 0.15}));
    Hand hand;
    hand.palm = {0, 0, 0.15};
    RenderOptions options;
    const double speed = GENERATE(7.0, 0.7, 5.3);
    options.touch.pace = Pace{speed, {}};
    options.dwell = GENERATE(1U, 7U, 10U);
    const Rendered rendered = render(sphere, one_frame(hand), find_array("tile-10x10"), carrier_hz, options);
    CHECK(rendered.frames.at(0).out_of_reach == 0.0);
    double way = 0.0;
    std::uint64_t periods = 0;
    std::uint32_t least = 1000, most = 0;
    double shortest = 1.0, longest = 0.0;
    const auto& steps = rendered.path.steps;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        REQUIRE(steps[i].foci.size() == 1);
        const double step = distance(steps[i].foci[0].position, steps[(i + 1) % steps.size()].foci[0].position);
        way += step;
        shortest = std::min(shortest, step);
        longest = std::max(longest, step);
        periods += steps[i].periods;
        least = std::min(least, steps[i].periods);
        most = std::max(most, steps[i].periods);
    }
    CHECK(way * carrier_hz / static_cast<double>(periods) == Approx(speed).epsilon(0.01));
    CHECK(most - least <= 1);
    CHECK(longest - shortest < 0.02 * longest);
    CHECK(rendered.frames.at(0).draw_hz == Approx(speed / (2 * pi * 0.04)).epsilon(0.003));
}

TEST_CASE("render: a recording takes its time, and the foci go on where they were", "[render]") {
    HandRecording recording;
    for (int i = 0; i < 20; ++i)
        recording.frames.push_back({0.009 * i, {synthetic_hand(HandScript::press, 0.0, 0.15)}});
    recording.frames[5].hands.clear();  // the tracker lost the hand
    const TouchObject sphere = built_in_object("sphere", measures_of(0.06, {0, 0, 0.15}));
    const Array array = find_array("tile-10x10");
    const Rendered rendered = render(sphere, recording, array, carrier_hz, {});
    CHECK(rendered.frames.size() == 20);
    CHECK(static_cast<double>(rendered.path.periods()) == Approx(20 * 0.009 * carrier_hz).margin(10));
    // A still hand: steps are as long at the frames' seams as elsewhere, but for the jumps and the silent frame.
    std::size_t time = 0, silent = 0, leaps = 0;
    Vec3 last{};
    for (const PathStep& step : rendered.path.steps) {
        if (step.foci.empty()) {
            silent += step.periods;
            CHECK(static_cast<double>(time) == Approx(0.045 * carrier_hz).margin(10));
        } else {
            leaps += time > 0 && distance(last, step.foci[0].position) > 2e-3 ? 1 : 0;
            last = step.foci[0].position;
        }
        time += step.periods;
    }
    CHECK(static_cast<double>(silent) == Approx(0.009 * carrier_hz).margin(10));
    const double passes = 0.18 * rendered.frames[0].draw_hz;
    CHECK(static_cast<double>(leaps) <= (passes + 1) * static_cast<double>(rendered.frames[0].lines));
    CHECK(rendered.frames[5].foci == 0);
}

TEST_CASE("render: a tracker that is silent for more than two frames fades, and plays again", "[render]") {
    const TouchObject object = built_in_object("half-space", measures_of(0.1, {0, 0, 0.2}));
    HandRecording hands;
    for (int i = 0; i < 60; ++i)
        if (i < 20 || i > 40) hands.frames.push_back({i / 100.0, {synthetic_hand(HandScript::wave, i / 100.0, 0.2)}});
    const Rendered made = render(object, hands, find_array("tile-10x10"), carrier_hz, {});
    double time_s = 0.0, silent_s = 0.0, begin_s = 0.0, weaker_s = 0.0;
    for (const PathStep& step : made.path.steps) {
        const double seconds = step.periods / carrier_hz;
        if (time_s > 0.19 && time_s < 0.405 && step.foci.empty()) {
            if (silent_s == 0.0) begin_s = time_s;
            silent_s += seconds;
        }
        if (!step.foci.empty() && step.foci.front().amplitude < 1.0) weaker_s += seconds;
        time_s += seconds;
    }
    CHECK(begin_s == Approx(0.22).margin(1e-3));  // 0.19 s, and three frames
    CHECK(silent_s == Approx(0.19).margin(1e-3));
    CHECK(weaker_s == Approx(0.01).margin(1e-3));
    CHECK_SAID(made.warnings.front());
}

TEST_CASE("skin: a finger that goes straight down into a face feels the circle of its round tip", "[render]") {
    // Closed forms: a sphere of radius r that is d deep cuts the face in a circle of radius √(2rd − d²), and the finger
    // behind it in one of radius r.
    constexpr double r = 7.5e-3, face = 0.2;
    const TouchObject object = built_in_object("half-space", measures_of(0.1, {0, 0, face}));
    for (const double depth : {1e-3, 2e-3, 5e-3, 15e-3}) {
        Hand hand;
        hand.palm = {0, 0, 0.3};
        hand.normal = {0, -1, 0};
        hand.direction = {0, 0, -1};
        const double tip = face - depth + r;
        hand.fingers[1] = Finger{{Vec3{0, 0, tip + 80e-3}, {0, 0, tip + 45e-3}, {0, 0, tip + 20e-3}, {0, 0, tip}}, {}};
        const Touch made = touch_of(Algorithm::intersection, object, palmar_surface(hand));
        const double wanted = depth < r ? std::sqrt(2.0 * r * depth - depth * depth) : r;
        REQUIRE_FALSE(made.lines.empty());
        INFO(depth);
        for (const SkinLine& line : made.lines)
            for (const SkinPoint& point : line.points) {
                CHECK(std::hypot(point.position.x, point.position.y) == Approx(wanted).epsilon(0.05));
                CHECK(point.position.z == Approx(face).margin(1e-4));
            }
        // The round tip is felt all around, the finger's side on its palmar half.
        const double around = depth < r ? 2.0 * pi * wanted : pi * wanted;
        CHECK(length_of(made.lines) == Approx(around).epsilon(0.05));
    }
}

TEST_CASE("render: two foci at the same time for C, and its point is modulated", "[render]") {
    const TouchObject sphere = built_in_object("sphere", measures_of(0.08, {0, 0, 0.15}));
    Hand hand;
    hand.palm = {0, 0, 0.16};
    RenderOptions options;
    options.algorithm = Algorithm::deepest;
    options.touch.pace = Pace{{}, 25.0};
    const Rendered rendered = render(sphere, one_frame(hand), find_array("tile-10x10"), carrier_hz, options);
    REQUIRE(rendered.path.steps.size() == 160);
    // 200 Hz in a pass of 40 ms is eight periods: 20 steps each, ½ + ½·sin.
    for (std::size_t i = 0; i < 160; ++i) {
        const auto& foci = rendered.path.steps[i].foci;
        const double expected = 0.5 + 0.5 * std::sin(2 * pi * (static_cast<double>(i % 20) + 0.5) / 20.0);
        REQUIRE(foci.size() == 2);
        CHECK(foci[0].amplitude == 1.0);
        CHECK(foci[1].amplitude == Approx(expected).margin(1e-9));
        CHECK(distance(foci[1].position, {0, 0, 0.16}) < 1e-3);
    }
    // What the second focus costs (phases alone): each has about 0.67 of the pressure of one alone.
    const Array array = find_array("tile-10x10");
    const std::vector<Focus> two{{from_mm(15, 0, 150)}, {from_mm(-15, 0, 150)}}, one{{from_mm(0, 0, 150)}};
    SolveOptions solver;
    solver.method = Method::superposition;
    const double pair = quality_of(array, two, solve(array, two, solver)).pressure_pa[0];
    const double alone = quality_of(array, one, solve(array, one, solver)).pressure_pa[0];
    CHECK(pair / alone == Approx(0.67).margin(0.02));
}

TEST_CASE("render: the width of a focus over the height, for an array of 16 x 16 point sources", "[render]") {
    // Where |p|² falls to half, by scipy's root finder on the plain sum of spheres. Beside it, what a search in steps
    // of 0.02 mm finds first below the half, rounded up to whole steps.
    struct Width {
        double z_mm, exact_mm, searched_mm;
    };
    const auto [z_mm, exact_mm, searched_mm] = GENERATE(
        Width{100.0, 5.937, 5.96}, Width{150.0, 7.898, 7.92}, Width{200.0, 9.993, 10.00}, Width{300.0, 14.371, 14.40},
        Width{400.0, 18.858, 18.88}, Width{500.0, 23.394, 23.40}, Width{600.0, 27.955, 27.96});
    CAPTURE(z_mm);
    const double found_mm = focal_width(point_sources(), {0, 0, z_mm * millimetre}) / millimetre;
    CHECK(found_mm == Approx(exact_mm).margin(0.001));
    CHECK(2.0 * 0.02 * std::ceil(found_mm / 2.0 / 0.02) == Approx(searched_mm).margin(1e-9));
}

TEST_CASE("render: tilt of the skin, and skin that faces away", "[render]") {
    const TouchObject cube = built_in_object("cube", measures_of(0.05, {0, 0, 0.2}));
    const Array array = find_array("tile-10x10");
    const auto tilt = [&](double degrees) {
        Hand hand;
        const double angle = degrees * pi / 180.0;
        hand.palm = {0, 0, 0.2};
        hand.normal = {std::sin(angle), 0, -std::cos(angle)};
        return render(cube, one_frame(hand), array, carrier_hz, {}).frames.at(0);
    };
    // The places that are drawn lie up to 7° off the axis, which takes off a little at 0° and nothing to first order.
    for (const auto& [degrees, expected] :
         {std::pair(0.0, 1.0), {15.0, 0.933}, {30.0, 0.75}, {45.0, 0.5}, {60.0, 0.25}, {75.0, 0.067}}) {
        CAPTURE(degrees);
        CHECK(tilt(degrees).tilt == Approx(expected).margin(0.03));
    }
    const FrameReport away = tilt(180.0);
    CHECK(away.tilt == 0.0);
    CHECK(away.weak == 1.0);
}

TEST_CASE("render: strength falls with the length, and what is too weak is said", "[render]") {
    const Array array = find_array("tile-10x10");
    Hand hand;
    hand.palm = {0, 0, 0.15};
    const auto report = [&](double size) {
        return render(built_in_object("sphere", measures_of(size, {0, 0, 0.15})), one_frame(hand), array, carrier_hz,
                      {})
            .frames.at(0);
    };
    const FrameReport small = report(0.03), large = report(0.06);
    CHECK(small.strength_pa / large.strength_pa == Approx(large.length_m / small.length_m).epsilon(0.01));
    CHECK(small.strength_pa == Approx(small.focus_pa * small.width_m / small.length_m));
    CHECK(small.weak <= large.weak);
}

TEST_CASE("render: hands and objects that do not meet are named, and nothing is lost silently", "[render]") {
    const Array array = find_array("tile-10x10");
    Hand hand = synthetic_hand(HandScript::press, 0.0, 0.2);
    const TouchObject sphere = built_in_object("sphere", measures_of(0.05, {0, 0, 0.2}));
    const auto refuses = [&](const TouchObject& object, const HandRecording& recording, const std::string& words,
                             RenderOptions options = {}) {
        CAPTURE(words);
        REQUIRE_REFUSED(render(object, recording, array, carrier_hz, options));
    };
    refuses(sphere, {}, "no frames");
    refuses(sphere, {{{0.0, {}}}}, "no hand");
    refuses(sphere, {{{0.0, {}}, {0.01, {}}}}, "no hand");
    refuses(built_in_object("sphere", measures_of(0.05, {0, 0, 0.3})), one_frame(hand),
            "nearest, to 75.0 mm, in frame 1");
    RenderOptions b;
    b.algorithm = Algorithm::features;
    refuses(sphere, one_frame(hand), "algorithm B has nothing to draw", b);
    RenderOptions frame;
    frame.frame = 2;
    refuses(sphere, one_frame(hand), "found 2, expected 1 to 1", frame);
    RenderOptions points;
    points.points = 1'000'000;
    refuses(sphere, one_frame(hand), "fewer points", points);
    hand.palm = {0, 0, 5.0};
    hand.fingers = {};
    refuses(built_in_object("sphere", measures_of(0.05, {0.5, 0, 0.1})), one_frame([&] {
                Hand far = hand;
                far.palm = {0.5, 0, 0.1};
                return far;
            }()),
            "out of the array's reach");
    Hand nan = synthetic_hand(HandScript::press, 0.0, 0.2);
    nan.fingers[2]->joints[1].y = std::numeric_limits<double>::quiet_NaN();
    refuses(sphere, one_frame(nan), "frame 1");
    Hand parallel = synthetic_hand(HandScript::press, 0.0, 0.2);
    parallel.direction = parallel.normal;
    refuses(sphere, one_frame(parallel), "parallel");
    TouchOptions wrong;
    wrong.solid_level = 1.5;
    REQUIRE_REFUSED(touch_of(Algorithm::solid, sphere, plane_at(0.2), 0.0, wrong));
    wrong = {};
    wrong.pace = Pace{7.0, 20.0};
    REQUIRE_REFUSED(touch_of(Algorithm::intersection, sphere, plane_at(0.2), 0.0, wrong));
    REQUIRE_REFUSED(
        open_object({.name = "torus", .size_m = {}, .height_m = {}, .centre = {}, .angles_deg = {}, .unit = "mm"}));
    REQUIRE_REFUSED(open_hands("synthetic:clap"));
    REQUIRE_REFUSED(open_hands("synthetic:press:low"));
}

TEST_CASE("render: few of the skin's points are asked for their distance", "[render]") {
    // `make bench` measures the milliseconds; this holds on any processor.
    const char* const kind = GENERATE("sphere", "cube", "cone", "pyramid", "cylinder");
    TouchObject object = built_in_object(kind, {});
    std::size_t asked = 0;
    object.solid.distance = [&asked, exact = object.solid.distance](Vec3 p) {
        ++asked;
        return exact(p);
    };
    for (const AlgorithmName& one : algorithm_names()) {
        std::size_t points = 0, lines = 0;
        asked = 0;
        for (int i = 0; i < 10; ++i) {
            const auto skin = palmar_surface(synthetic_hand(HandScript::press, 0.1 * i, 0.23));
            for (const SkinRegion& region : skin) points += region.points.size();
            lines += touch_of(algorithm_of(one.name), object, skin, 0.1 * i).lines.size();
        }
        CAPTURE(kind, one.letter, asked, points);
        if (one.letter != 'B') CHECK(lines >= 10);  // B has edges and corners, of which a sphere has none
        // What depends on the depth, and not on the outline alone, asks for every point inside.
        const bool outline = std::string_view("ABEFHK").find(one.letter) != std::string_view::npos;
        CHECK((outline ? 10 : 2) * asked <= points);
    }
}
