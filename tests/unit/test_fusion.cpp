// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/skin_force.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/robot/modes.hpp"
#include "haptogram/robot/place.hpp"
#include "haptogram/robot/scenes.hpp"
#include "haptogram/verbs/focus_analysis.hpp"

using namespace haptogram;
using namespace haptogram::fusion;
using robot::Vector3;
using std::numbers::pi;

namespace {

const Array& hoshi() {
    static const Array array = find_array("hoshi-18x18");
    return array;
}

const perception::Tables& tables() {
    static const perception::Tables found = perception::find_tables();
    return found;
}

}  // namespace

TEST_CASE("fusion: one clock counts whole carrier periods for both stages", "[fusion]") {
    const SharedClock clock = shared_clock(0.030, 40000.0);
    REQUIRE(clock.carrier_periods == 1200);
    REQUIRE(1.0 / clock.period_s() == Approx(33.3).margin(0.05));
    REQUIRE_REFUSED(shared_clock(0.03001, 40000.0));
    REQUIRE_THROWS_AS(shared_clock(0.0, 40000.0), Error);
}

TEST_CASE("fusion: edges and corners of a cube meet the plane of the palm", "[fusion]") {
    const Hand hand = open_hand(from_mm(0, 0, 200), 0.0);
    const std::vector<SkinRegion> skin = palmar_surface(hand);
    ObjectMeasures measures;
    measures.size = 0.040;
    const auto near = [](const std::vector<Vec3>& points, Vec3 wanted) {
        return std::count_if(points.begin(), points.end(), [&](Vec3 p) { return distance(p, wanted) < 1e-9; });
    };
    // The plane is in the cube's middle: its four upright edges, and no corner.
    measures.centre = hand.palm;
    const std::vector<Vec3> middle = slice_points(built_in_object("cube", measures), hand, skin);
    REQUIRE(middle.size() == 4);
    for (const double x : {-20.0, 20.0})
        for (const double y : {-20.0, 20.0}) REQUIRE(near(middle, from_mm(x, y, 200)) == 1);
    // 3 mm below its top: the four upper corners, too, laid onto the skin.
    measures.centre = hand.palm - from_mm(0, 0, 17);
    const std::vector<Vec3> top = slice_points(built_in_object("cube", measures), hand, skin);
    REQUIRE(top.size() == 8);
    for (const double x : {-20.0, 20.0}) REQUIRE(near(top, from_mm(x, 20, 200)) == 2);
    // Beside the hand there is nothing to feel.
    measures.centre = hand.palm + from_mm(200, 0, 0);
    REQUIRE(slice_points(built_in_object("cube", measures), hand, skin).empty());
}

TEST_CASE("fusion: a plane cuts a tilted palm where its height is", "[fusion]") {
    constexpr double tilt = 20.0;
    for (const double above_mm : {-10.0, 0.0, 4.0, 12.0}) {
        CAPTURE(above_mm);
        const Hand hand = open_hand(from_mm(3, -5, 250 + above_mm), tilt);
        REQUIRE(norm(hand.normal) == Approx(1.0));
        REQUIRE(dot(hand.normal, hand.direction) == Approx(0.0).margin(1e-12));
        const std::vector<SkinRegion> skin = palmar_surface(hand);
        double length = 0.0;
        std::vector<SkinLine> on_palm;
        for (const SkinLine& line : plane_lines(skin, 0.25)) {
            for (const SkinPoint& point : line.points) REQUIRE(point.position.z == Approx(0.25).margin(0.2e-3));
            if (skin[line.region].name != "palm") continue;
            on_palm.push_back(line);
            length += length_of(line);
            for (const SkinPoint& point : line.points)
                REQUIRE(dot(point.position - hand.palm, hand.direction) ==
                        Approx(above_mm * 1e-3 / std::sin(tilt * pi / 180)).margin(1e-6));
        }
        REQUIRE(length == Approx(0.085).margin(1e-3));  // right across
        const std::vector<Vec3> points = spread(on_palm, 5);
        REQUIRE(points.size() == 5);
        for (std::size_t i = 1; i < 5; ++i) REQUIRE(distance(points[i - 1], points[i]) == Approx(length / 5));
    }
    REQUIRE(plane_lines(palmar_surface(open_hand(from_mm(0, 0, 400), tilt)), 0.25).empty());
    REQUIRE(spread({}, 5).empty());
}

TEST_CASE("fusion: a surface carries, rubs and has a texture that gives back its work", "[fusion]") {
    Surface surface;
    REQUIRE(surface_force(surface, {0, 0, 0.001}, {1, 1, 1}).norm() == 0.0);
    const double normal = 1000 * 0.001;
    REQUIRE(surface_force(surface, {0, 0, -0.001}, {0, 0, 0}).z() == Approx(normal));
    surface.texture = 0.0;
    const Vector3 sliding = surface_force(surface, {0, 0, -0.001}, {0.03, -0.04, 0.2});
    REQUIRE(std::hypot(sliding.x(), sliding.y()) == Approx(0.4 * normal));
    REQUIRE(sliding.x() * 0.04 + sliding.y() * 0.03 == Approx(0.0).margin(1e-12));
    REQUIRE(sliding.x() < 0.0);
    REQUIRE(surface_force(surface, {0, 0, -0.001}, {0.005, 0, 0}).x() == Approx(-0.4 * normal * 0.25));
    // Along a closed way the texture does no work; over half a cell it does what the sine's integral says.
    surface = {};
    surface.friction = 0.0;
    double around = 0.0, half_cell = 0.0;
    constexpr int steps = 20000;
    for (int i = 0; i < steps; ++i) {
        const double angle = 2 * pi * (i + 0.5) / steps, radius = 0.0137;
        const Vector3 place(radius * std::cos(angle) + 0.002, radius * std::sin(angle), -0.001);
        const Vector3 way = 2 * pi * radius / steps * Vector3(-std::sin(angle), std::cos(angle), 0);
        around += surface_force(surface, place, Vector3::Zero()).dot(way);
        const double x = 0.005 * (i + 0.5) / steps;
        half_cell += surface_force(surface, {x, 0, -0.001}, Vector3::Zero()).x() * 0.005 / steps;
    }
    REQUIRE(around == Approx(0.0).margin(1e-9));
    REQUIRE(half_cell == Approx(-0.3 * normal * 0.010 / pi));
    surface.cell_m = 0.0;
    REQUIRE_REFUSED(surface_force(surface, Vector3::Zero(), Vector3::Zero()));
    // Weight and surface together hold a body at rest at depth weight/stiffness.
    const Hand hand = open_hand(from_mm(0, 0, 200), 0.0);
    const Stimulus stimulus =
        explore(built_in_object("cube", {}), hand, palmar_surface(hand), 1.0, {}, {0, 0, -0.001}, Vector3::Zero());
    REQUIRE(stimulus.wrench.norm() == Approx(0.0).margin(1e-12));
}

TEST_CASE("fusion: patterns on the palm tell a value by each sign", "[fusion]") {
    const Hand palm = open_hand(from_mm(10, 20, 250), 0.0);
    PalmPattern pattern;
    REQUIRE(tell(pattern, 0.25, palm).frequency_hz == Approx(135.0));
    REQUIRE(tell(pattern, 0.25, palm).magnitude == 2.0);
    REQUIRE(distance(tell(pattern, 0.25, palm).points.at(0), palm.palm) < 1e-15);
    pattern = {.sign = PalmSign::intensity, .low = 1, .high = 4};
    REQUIRE(tell(pattern, 0.5, palm).magnitude == Approx(2.5));
    REQUIRE(tell(pattern, 0.5, palm).frequency_hz == 200.0);
    pattern = {.sign = PalmSign::translation, .low = -0.02, .high = 0.03};
    REQUIRE(distance(tell(pattern, 1.0, palm).points.at(0), palm.palm + from_mm(0, 30, 0)) < 1e-12);
    pattern = {.sign = PalmSign::scaling, .shape = PalmShape::ring, .low = 0.5, .high = 1.5};
    for (const Vec3& point : tell(pattern, 1.0, palm, 12).points) REQUIRE(distance(point, palm.palm) == Approx(0.015));
    pattern = {.sign = PalmSign::rotation, .shape = PalmShape::line, .low = 0, .high = 90};
    for (const double value : {0.0, 0.5, 1.0}) {
        const std::vector<Vec3> points = tell(pattern, value, palm, 7).points;
        const Vec3 way = points.back() - points.front();
        REQUIRE(norm(way) == Approx(0.020));
        REQUIRE(dot(way, palm.direction) == Approx(0.020 * std::cos(value * pi / 2)).margin(1e-12));
    }
    REQUIRE_REFUSED(tell(pattern, 1.01, palm, 7));
    REQUIRE_REFUSED(tell(pattern, 0.5, palm, 1));
    pattern.shape = PalmShape::ring;
    REQUIRE_REFUSED(tell(pattern, 0.5, palm, 7));
    REQUIRE(palm_sign("scaling") == PalmSign::scaling);
    REQUIRE_THROWS_AS(palm_sign("colour"), Error);

    REQUIRE(nearness(-0.03, 0.1) == Approx(0.7));
    REQUIRE(nearness(0.2, 0.1) == 0.0);
    REQUIRE(hardness(1000, 100, 10000) == Approx(0.5));
    REQUIRE_THROWS_AS(hardness(99, 100, 10000), Error);
    double mean = 0.0;
    for (int i = 0; i < 100; ++i)
        for (int j = 0; j < 100; ++j) mean += cloth(i * 1e-4, j * 1e-4, 0.01) / 1e4;
    REQUIRE(mean == Approx(0.5));
    REQUIRE(cloth(0.0025, 0.0025, 0.01) == Approx(1.0));
}

TEST_CASE("fusion: the square wave goes on from frame to frame at any frequency", "[fusion]") {
    const SharedClock clock = shared_clock(0.030, 40000.0);
    FramePen pen(hoshi(), tables(), clock);
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> frequency(80.0, 300.0);
    Stimulus stimulus;
    stimulus.points = {from_mm(0, 0, 250)};
    std::uint64_t now = 0, on = 0;
    std::vector<std::uint64_t> rises;
    double turns = 0.0;  // of the wave that was asked for
    bool was_on = false;
    for (int n = 0; n < 40; ++n) {
        stimulus.frequency_hz = n < 20 ? frequency(random) : 200.0;
        const Frame frame = pen.play(stimulus);
        REQUIRE(frame.path.periods() == 1200);
        REQUIRE_NOTHROW(require_sound(frame.path));
        for (const PathStep& step : frame.path.steps) {
            const bool is_on = !step.foci.empty();
            if (is_on && !was_on) rises.push_back(now);
            if (is_on) on += step.periods;
            was_on = is_on;
            now += step.periods;
        }
        turns += stimulus.frequency_hz * 0.030;
        // A wave that starts again in each frame would have lost or gained rises by now.
        REQUIRE(std::abs(static_cast<double>(rises.size()) - turns) <= 1.0 + 1e-6);
    }
    REQUIRE(static_cast<double>(on) / static_cast<double>(now) == Approx(0.5).margin(0.01));
    for (std::size_t i = rises.size() - 100; i < rises.size(); ++i) REQUIRE(rises[i] - rises[i - 1] == 200);
    // Several points share the frame, each for whole periods of the wave.
    stimulus.points = {from_mm(0, 0, 250), from_mm(10, 0, 250), from_mm(20, 0, 250)};
    FramePen fresh(hoshi(), tables(), clock);
    const Frame shared = fresh.play(stimulus);
    REQUIRE(fresh.places(200.0) == 6);
    std::vector<double> seen;
    for (const PathStep& step : shared.path.steps)
        if (!step.foci.empty()) {
            REQUIRE(step.periods == 100);
            REQUIRE(step.foci.size() == 1);
            seen.push_back(step.foci[0].position.x);
        }
    REQUIRE(seen == std::vector<double>{0, 0.01, 0.02, 0, 0.01, 0.02});
    stimulus.points.resize(7, from_mm(0, 0, 250));
    REQUIRE_REFUSED(fresh.play(stimulus));
    // What the tables do not know is an error, and what the array cannot do at a place is silence that is counted.
    stimulus.points = {from_mm(0, 0, 250)};
    stimulus.magnitude = 0.5;
    REQUIRE_REFUSED(fresh.play(stimulus));
    stimulus.magnitude = 2.0;
    stimulus.points = {from_mm(0, 0, 250), from_mm(0, 900, 100)};
    const Frame half = fresh.play(stimulus);
    REQUIRE(half.points.size() == 1);
    REQUIRE(half.silent == 1);
    REQUIRE_FALSE(half.why.empty());
    stimulus.points.clear();
    const Frame silence = fresh.play(stimulus);
    REQUIRE(silence.path.steps == std::vector<PathStep>{{{}, 1200}});
}

TEST_CASE("fusion: a frame's command gives the output of the magnitude, by the array's own pressure", "[fusion]") {
    FramePen pen(hoshi(), tables(), shared_clock(0.030, 40000.0));
    Stimulus stimulus;
    stimulus.frequency_hz = 180.0;
    stimulus.magnitude = 2.0;
    stimulus.points = {from_mm(0, 0, 250), from_mm(30, -20, 250)};
    const Frame frame = pen.play(stimulus);
    REQUIRE(frame.points.size() == 2);
    // Equal magnitude means equal force: on a disc at both places the sums over small cells are the same.
    double forces[2] = {0.0, 0.0};
    for (std::size_t which = 0; which < 2; ++which) {
        const Vec3 focus = frame.points[which].position;
        const auto drives = ideal_drives(hoshi(), focus);
        constexpr double cell = 1e-3;
        for (double x = -9.5e-3; x < 10e-3; x += cell)
            for (double y = -9.5e-3; y < 10e-3; y += cell)
                if (std::hypot(x, y) < 10e-3) {
                    const auto waves = waves_at_patch(hoshi(), focus + Vec3{x, y, 0}, {0, 0, -1});
                    forces[which] += std::pow(frame.points[which].setting.command, 2) *
                                     radiation_pressure(sound_at_patch(waves, drives), hoshi().medium);
                }
        // The textbook formula for eq. 10 at 180 Hz gives the output of 2.
        const double g = -12.46, j = 20.88, v = -0.1070 - 2.0;
        REQUIRE(frame.points[which].setting.needed_gf == Approx((-j + std::sqrt(j * j - 4 * g * v)) / (2 * g)));
        REQUIRE(magnitude_of(tables(), 180.0, frame.points[which], frame.points[which].setting.command) == Approx(2.0));
    }
    REQUIRE(forces[0] == Approx(forces[1]).epsilon(0.01));
}

TEST_CASE("fusion: bursts at the pins tell the modulation's frequency", "[fusion][analysis]") {
    constexpr std::uint64_t cycle = 1250;
    std::vector<Pulse> pulses;
    // 90 Hz: on for 222 cycles of each 444.4; channel 1 has fewer pulses and is not looked at.
    for (std::uint64_t n = 0; n < 4000; ++n)
        if (std::fmod(static_cast<double>(n) * 90.0 / 40000.0 + 0.3, 1.0) < 0.5) {
            const std::uint64_t jitter = n % 7 * 50;
            pulses.push_back({n * cycle + jitter, n * cycle + jitter + 100, 0, static_cast<std::uint16_t>(1 + n % 2)});
            if (n % 3 == 0) pulses.push_back({n * cycle, n * cycle + 100, 1, 1});
        }
    const Envelope envelope = envelope_of(pulses, 50e6, cycle);
    REQUIRE(envelope.bursts == 9);  // in 0.1 s; the first one had begun before
    REQUIRE(envelope.frequency_hz == Approx(90.0).epsilon(0.002));
    REQUIRE(envelope_of({}, 50e6, cycle).frequency_hz == 0.0);
    const Vec3 focus = from_mm(0, 0, 200);
    auto drives = ideal_drives(hoshi(), focus);
    for (auto& drive : drives) drive *= 0.37;
    REQUIRE(share_of_full_drive(hoshi(), drives, focus) == Approx(0.37));
}

TEST_CASE("fusion: a cube is placed by each of the three mappings", "[fusion][place]") {
    const SharedClock clock = shared_clock(0.030, 40000.0);
    for (const std::string name : {"G1", "G2", "G3"}) {
        PlaceOptions options;
        options.mapping = mapping_of(name);
        options.geometry = robot::find_geometry();
        options.plant.seed = Catch::rngSeed();
        const Placed placed = place_cube(options, hoshi(), tables(), clock);
        INFO(name << ": " << placed.error_m * 1e3 << " mm after " << placed.time_s << " s, " << placed.weight_n
                  << " N, " << placed.silent << " of " << placed.points << " points silent");
        for (const robot::Event& event : placed.events) UNSCOPED_INFO(event.text);
        REQUIRE(placed.placed);
        CHECK(std::abs(placed.error_m) < 2e-3);
        CHECK(placed.weight_n == Approx(options.weight_n).margin(0.02));  // what is held at rest is the weight
        CHECK(placed.measured_n == Approx(options.weight_n).margin(0.05));
        CHECK(placed.least_tension_n >= 0.5);
        REQUIRE(placed.rows.size() == placed.frames.size());
        double lowest = 1.0;
        for (std::size_t i = 1; i < placed.rows.size(); ++i) {
            const PlaceRow& row = placed.rows[i];
            lowest = std::min(lowest, row.height_m);
            REQUIRE(row.time_s == Approx(static_cast<double>(i + 1) * 0.030));
            REQUIRE(placed.frames[i].path.periods() == 1200);
            REQUIRE(row.scene_n == -options.weight_n);
            // What was asked follows from where the cube was when the period began.
            const double off = std::abs(placed.rows[i - 1].height_m - 0.25);
            if (name == "G2") REQUIRE(row.frequency_hz == Approx(300.0 - 220.0 * off / 0.1));
            if (name == "G3") REQUIRE(row.magnitude == Approx(4.0 - 3.0 * off / 0.1));
            if (name == "G1" && row.line_m)
                REQUIRE(*row.line_m ==
                        Approx((placed.rows[i - 1].height_m - 0.25) / std::sin(20 * pi / 180)).margin(1e-5));
        }
        CHECK(lowest < 0.25);  // the user went past it, and came back
    }
    PlaceOptions wrong;
    wrong.geometry = robot::find_geometry();
    wrong.start_m = 0.2;
    REQUIRE_REFUSED(place_cube(wrong, hoshi(), tables(), clock));
    wrong.start_m = 0.3;
    REQUIRE_REFUSED(place_cube(wrong, hoshi(), tables(), shared_clock(0.020, 40000.0)));
    REQUIRE_THROWS_AS(mapping_of("G4"), Error);
}

namespace {

/// A run of a scene under a hand that goes straight from place to place (mm above the array), and waits at the end.
SceneRun played(const Scene& scene, const std::vector<Vector3>& way_mm, double weight_n, double speed_m_s,
                double wait_s) {
    TogetherOptions options;
    options.geometry = robot::find_geometry();
    options.plant.seed = Catch::rngSeed();
    HandWay way{{}, speed_m_s, wait_s, {}, weight_n};
    for (const Vector3& place : way_mm) way.places.push_back(Vec3{place.x(), place.y(), place.z()} * 1e-3);
    const SharedClock clock = shared_clock(0.030, 40000.0);
    return play_scene(scene, way, options, hoshi(), tables(), clock);
}

ExploreScene cube_and_surface() {
    ExploreScene scene;
    ObjectMeasures measures;
    measures.size = 0.060;
    measures.centre = {0.0, 0.0, 0.25};
    scene.object = built_in_object("cube", measures);
    scene.surface.height_m = 0.240;
    return scene;
}

}  // namespace

TEST_CASE("fusion: mode W1 as a run, a hand on a surface at rest, sliding, and at the edges of a cube",
          "[fusion][scene]") {
    const SharedClock clock = shared_clock(0.030, 40000.0);
    const ExploreScene scene = cube_and_surface();
    // Down onto the surface, 4 mm deeper than it is, and along it over 80 mm.
    const SceneRun run =
        played(scene_of(scene, clock), {{-40, 5, 250}, {-40, 5, 236}, {40, 5, 236}}, scene.weight_n, 0.05, 1.5);
    for (const robot::Event& event : run.events) UNSCOPED_INFO(event.text);
    REQUIRE(run.events.empty());
    CHECK(run.least_tension_n >= 0.5);
    for (std::size_t i = 0; i < run.periods.size(); ++i) {
        REQUIRE(run.periods[i].time_s == Approx(static_cast<double>(i + 1) * 0.030));
        REQUIRE(run.periods[i].frame.path.periods() == 1200);
    }
    REQUIRE(run.path().periods() == 1200 * run.periods.size());
    // At rest the hand's spring and the surface's balance: k_h·(z_h − z) + k_s·(h − z) = 0.
    const Period& last = run.periods.back();
    CHECK(last.palm.z * 1e3 == Approx((100.0 * 236.0 + 1000.0 * 240.0) / 1100.0).margin(0.1));
    CHECK(last.user.z() + last.stimulus.wrench[2] == Approx(0.0).margin(0.03));
    // While it slides, friction is 0.4 of the normal force; the texture gives back its work over whole cells.
    double normal = 0.0, tangential = 0.0, texture = 0.0;
    for (const Period& period : run.periods) {
        const Vec3& palm = period.before.body;
        if (palm.x < -0.020 || palm.x > 0.020 || palm.z > 0.240) continue;  // four cells of 10 mm
        const double force = period.stimulus.wrench[2] + scene.weight_n;
        CHECK(force == Approx(1000.0 * (0.240 - palm.z)));
        normal += force;
        tangential += period.stimulus.wrench[0];
        texture = std::max(texture, std::abs(period.stimulus.wrench[0] / force + 0.4));
    }
    REQUIRE(normal > 1.0);
    CHECK(-tangential / normal == Approx(0.4).margin(0.1));
    CHECK(texture == Approx(0.3).margin(0.1));
    // What is felt by ultrasound are the cube's upright edges, at ± 30 mm, where they meet the hand.
    std::size_t felt = 0;
    for (const Period& period : run.periods)
        for (const FramePoint& point : period.frame.points) {
            ++felt;
            REQUIRE(std::abs(std::abs(point.position.x) - 0.030) < 0.0101);
            REQUIRE(std::abs(std::abs(point.position.y) - 0.030) < 0.0101);
            REQUIRE(distance(point.position, period.before.palm) < 0.2);
        }
    CHECK(felt > 100);
    ExploreScene stiff = scene;
    stiff.surface.stiffness_n_m = 4445.0;
    REQUIRE_REFUSED(scene_of(stiff, clock));
}

TEST_CASE("fusion: more points than a frame has time for take turns", "[fusion][scene]") {
    const SharedClock clock = shared_clock(0.030, 40000.0);
    ExploreScene scene = cube_and_surface();
    scene.object = built_in_object("cube", {0.060, 0.1, {0.0, 0.0, 0.278}, {}});  // its lower corners are 2 mm off
    scene.frequency_hz = 80.0;                                                    // two points a frame
    REQUIRE(places_of(clock, 80.0) == 2);
    const Scene turns = scene_of(scene, clock);
    const Moment moment{0.0, {0.0, 0.0, 0.25}, {0.0, 0.0, 0.25}, Vector3::Zero()};
    const std::vector<Vec3> all = slice_points(scene.object, open_hand(moment.palm, 0.0),
                                               palmar_surface(open_hand(moment.palm, 0.0)), scene.slice);
    REQUIRE(all.size() > 2);
    std::vector<Vec3> seen;
    for (std::size_t frame = 0; 2 * frame < all.size(); ++frame) {
        const Stimulus stimulus = turns(moment);
        REQUIRE(stimulus.points.size() == 2);
        for (const Vec3& point : stimulus.points) seen.push_back(point);
    }
    for (const Vec3& point : all) REQUIRE(std::count(seen.begin(), seen.end(), point) >= 1);
}

TEST_CASE("fusion: mode W2 as a run, a ring that grows with nearness, and hardness only where it is touched",
          "[fusion][scene]") {
    TellScene told;
    told.pattern = {PalmSign::scaling, PalmShape::ring, 0.5, 2.0, 2.0, 200.0, 20e-3};
    const SceneRun run = played(scene_of(told), {{0, 0, 290}, {0, 0, 240}}, told.weight_n, 0.05, 2.0);
    REQUIRE(run.events.empty());
    for (const Period& period : run.periods) {
        REQUIRE(period.stimulus.wrench[2] == -1.0);
        REQUIRE(period.stimulus.points.size() == 6);
        const double off = std::abs(period.before.palm.z - 0.25);
        const double radius = 10e-3 * (0.5 + 1.5 * (1.0 - off / 0.1));
        for (const Vec3& point : period.stimulus.points)
            REQUIRE(distance(point, period.before.palm) == Approx(radius).epsilon(1e-9));
    }
    CHECK(run.periods.back().user.z() == Approx(1.0).margin(0.03));  // the weight is what the user holds at rest
    // Hardness by frequency: the geometric middle of the range is its middle.
    TellScene hard;
    hard.value = PalmValue::hardness;
    hard.stiffness_n_m = 500.0;
    const Scene scene = scene_of(hard);
    const Stimulus below = scene({0.0, {0.0, 0.0, 0.2499}, {0.0, 0.0, 0.2499}, Vector3::Zero()});
    CHECK(below.frequency_hz == Approx(80.0 + 220.0 * 0.5));
    REQUIRE(below.points.size() == 1);
    const Stimulus above = scene({0.0, {0.0, 0.0, 0.2501}, {0.0, 0.0, 0.2501}, Vector3::Zero()});
    CHECK(above.points.empty());
    CHECK(above.wrench[2] == -1.0);
    // A cloth by intensity: roughest in the middle of a quarter cell, of threads 20 mm apart.
    TellScene rough;
    rough.value = PalmValue::texture;
    rough.pattern.sign = PalmSign::intensity;
    rough.pattern.low = 1.0;
    rough.pattern.high = 4.0;
    const Scene cloth_scene = scene_of(rough);
    CHECK(cloth_scene({0.0, {0.005, 0.005, 0.24}, {0.005, 0.005, 0.24}, Vector3::Zero()}).magnitude == Approx(4.0));
    CHECK(cloth_scene({0.0, {-0.005, 0.005, 0.24}, {-0.005, 0.005, 0.24}, Vector3::Zero()}).magnitude == Approx(1.0));
    REQUIRE(palm_value("texture") == PalmValue::texture);
    REQUIRE_THROWS_AS(palm_value("colour"), Error);
    hard.stiffness_n_m = 1.0;
    REQUIRE_REFUSED(scene_of(hard));
    told.pattern.shape = PalmShape::focus;
    REQUIRE_REFUSED(scene_of(told));
    told.weight_n = -1.0;
    REQUIRE_REFUSED(scene_of(told));
}

TEST_CASE("fusion: a way from place to place with one speed", "[fusion][scene]") {
    const std::vector<Vector3> places = {{0, 0, 0}, {0.03, 0, 0}, {0.03, 0.04, 0}};
    REQUIRE(seconds_along(places, 0.01) == Approx(7.0));
    const auto there = along(places, 0.01);
    REQUIRE((there(0.0) - places[0]).norm() == 0.0);
    REQUIRE((there(1.5) - Vector3(0.015, 0, 0)).norm() < 1e-12);
    REQUIRE((there(5.0) - Vector3(0.03, 0.02, 0)).norm() < 1e-12);
    REQUIRE((there(100.0) - places[2]).norm() == 0.0);
    REQUIRE_REFUSED(along({}, 0.01));
    REQUIRE_REFUSED(along(places, 0.0));
}
