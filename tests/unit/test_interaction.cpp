// SPDX-License-Identifier: Apache-2.0
// Hoshi's movements, the tracked marker, and what the palm meets above the array.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/format/waveform.hpp"
#include "haptogram/hand/interaction.hpp"
#include "haptogram/hand/marker.hpp"
#include "haptogram/hand/movement.hpp"
#include "haptogram/hand/recording.hpp"

using namespace haptogram;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double carrier_hz = 40e3;

/// Where the focus of a path is, period by period; nothing in silence.
std::vector<std::optional<Vec3>> places(const Path& path) {
    std::vector<std::optional<Vec3>> all;
    for (const PathStep& step : path.steps) {
        std::optional<Vec3> place;
        if (!step.foci.empty()) place = step.foci.front().position;
        all.insert(all.end(), step.periods, place);
    }
    return all;
}

std::vector<MarkerSample> still(Vec3 palm, double seconds) {
    const Vec3 marker = palm - InteractionOptions{}.palm_from_marker;
    return {{0.0, marker}, {seconds, marker}};
}

InteractionOptions patient() {
    InteractionOptions options;
    options.longest_gap_s = 1e4;
    return options;
}

HandRecording recording_of(HandScript script, double height_m) {
    HandRecording recording;
    const double seconds = seconds_of(script);
    for (int i = 0; i <= static_cast<int>(seconds * 100); ++i)
        recording.frames.push_back({i / 100.0, {synthetic_hand(script, i / 100.0, height_m)}});
    return recording;
}

}  // namespace

TEST_CASE("grid: the 324 positions and the nearest of them", "[hoshi]") {
    const PositionGrid grid;
    const std::vector<Vec3> all = grid.positions();
    REQUIRE(all.size() == 324);
    REQUIRE(distance(all.front(), from_mm(-85, -85, 200)) < 1e-12);
    REQUIRE(distance(all[1], from_mm(-75, -85, 200)) < 1e-12);
    REQUIRE(distance(all.back(), from_mm(85, 85, 200)) < 1e-12);
    const PositionGrid high = interaction_grid();
    const std::vector<Vec3> layers = high.positions();
    REQUIRE(layers.size() == 324 * 16);
    REQUIRE(layers.back().z == Approx(0.3));
    std::mt19937_64 g(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    std::uniform_real_distribution<double> side(-0.15, 0.15), height(0.1, 0.35);
    for (int i = 0; i < 200; ++i) {
        const Vec3 point{side(g), side(g), height(g)};
        double least = 1.0;
        for (const Vec3& position : layers) least = std::min(least, distance(position, point));
        REQUIRE(distance(high.nearest(point), point) == Approx(least));
    }
}

TEST_CASE("movement: line and circle at their speed, with whole repetitions of the modulation", "[hoshi]") {
    MovementOptions options;
    options.modulation = modulation_of("square:200", AmplitudeLaw::pressure, carrier_hz).modulation;
    const std::size_t repetition = options.modulation.samples.size() * options.modulation.periods_a_sample;
    const MadeMovement line = movement_path(Movement::line, options, carrier_hz);
    const auto at = places(line.path);
    REQUIRE(at.size() == 40'000);  // 50 mm at 50 mm/s
    REQUIRE(at.size() % repetition == 0);
    REQUIRE(line.speed_m_s == Approx(0.05));
    for (std::size_t i = 0; i < at.size(); i += 37) {
        REQUIRE(std::abs(at[i]->x) < 1e-12);
        REQUIRE(at[i]->z == 0.2);
        // Never farther from the even motion than half a step, and a period of it.
        REQUIRE(std::abs(at[i]->y - (-0.025 + 0.05 * (static_cast<double>(i) + 0.5) / 40'000)) <= 0.25e-3 + 2e-6);
    }
    options.direction_rad = 0.0;
    options.speed_m_s = 0.03;
    const MadeMovement slow = movement_path(Movement::line, options, carrier_hz);
    REQUIRE(slow.path.periods() % repetition == 0);
    REQUIRE(slow.speed_m_s == Approx(0.03).epsilon(0.5 * static_cast<double>(repetition) / 66'000.0));
    REQUIRE(slow.speed_m_s == Approx(0.05 * carrier_hz / static_cast<double>(slow.path.periods())));
    REQUIRE(places(slow.path).front()->x < -0.0245);
    options.centre = from_mm(10, -20, 180);
    const MadeMovement circle = movement_path(Movement::circle, options, carrier_hz);
    const auto round = places(circle.path);
    REQUIRE(circle.length_m == Approx(pi * 0.05));
    for (std::size_t i = 0; i < round.size(); i += 911) {
        const Vec3 from_centre = *round[i] - options.centre;
        REQUIRE(norm(from_centre) == Approx(0.025));
        const double angle = 2.0 * pi * (static_cast<double>(i) + 0.5) / static_cast<double>(round.size());
        REQUIRE(std::abs(std::remainder(std::atan2(from_centre.y, from_centre.x) - angle, 2.0 * pi)) < 0.011);
    }
}

TEST_CASE("movement: the spiral has one speed and turns that are equally far apart", "[hoshi]") {
    MovementOptions options;
    options.turns = 4.0;
    options.spacing_m = 0.2e-3;
    const MadeMovement made = movement_path(Movement::spiral, options, carrier_hz);
    // The length as a sum of chords of r = aφ.
    double length = 0.0;
    const double a = 0.025 / (8.0 * pi);
    for (int i = 0; i < 200'000; ++i) {
        const double p = 8.0 * pi * i / 200'000, q = 8.0 * pi * (i + 1) / 200'000;
        length += std::hypot(a * q * std::cos(q) - a * p * std::cos(p), a * q * std::sin(q) - a * p * std::sin(p));
    }
    REQUIRE(made.length_m == Approx(length).epsilon(1e-6));
    REQUIRE(static_cast<double>(made.path.periods()) == Approx(length / 0.05 * carrier_hz).epsilon(1e-4));
    double last = -1.0, turned = 0.0, before = 0.0;
    const double step = made.length_m / static_cast<double>(made.path.steps.size());
    for (std::size_t i = 0; i < made.path.steps.size(); ++i) {
        const Vec3 p = made.path.steps[i].foci.front().position - options.centre;
        const double radius = norm(p), angle = std::atan2(p.y, p.x);
        if (i > 0) {
            turned += std::remainder(angle - before, 2.0 * pi);
            REQUIRE(distance(made.path.steps[i].foci.front().position, made.path.steps[i - 1].foci.front().position) ==
                    Approx(step).epsilon(0.03));
            REQUIRE(radius > last);
        } else {
            turned = angle;
        }
        // r = aφ: 6.25 mm a turn.
        REQUIRE(radius * 1e3 == Approx(6.25 * turned / (2.0 * pi)).margin(1e-6));
        before = angle;
        last = radius;
    }
    REQUIRE(last == Approx(0.025).epsilon(0.01));
}

TEST_CASE("movement: random hops are even over the positions, and the same for the same seed", "[hoshi]") {
    MovementOptions options;
    options.grid = PositionGrid{};
    options.size_m = 0.18;
    options.seconds = 300.0;
    options.seed = Catch::rngSeed();
    CAPTURE(Catch::rngSeed());
    const MadeMovement made = movement_path(Movement::random, options, carrier_hz);
    REQUIRE(made.path.periods() == 300 * 40'000);
    std::map<std::pair<long, long>, double> counts;
    for (const PathStep& step : made.path.steps) {
        REQUIRE(step.periods % 400 == 0);  // 10 ms
        const Vec3 p = step.foci.front().position;
        counts[{std::lround(p.x * 1e4), std::lround(p.y * 1e4)}] += step.periods / 400.0;
        REQUIRE(p.z == Approx(0.2));
    }
    REQUIRE(counts.size() == 324);
    double chi_square = 0.0;
    for (const auto& [place, count] : counts)
        chi_square += (count - 30'000 / 324.0) * (count - 30'000 / 324.0) / (30'000 / 324.0);
    REQUIRE(chi_square < 323 + 6.0 * std::sqrt(2.0 * 323));  // 323 degrees of freedom
    REQUIRE(movement_path(Movement::random, options, carrier_hz).path == made.path);
    options.seed += 1;
    REQUIRE(movement_path(Movement::random, options, carrier_hz).path != made.path);
}

TEST_CASE("movement: on the grid, the focus is where it would be, at most half a diagonal off", "[hoshi]") {
    MovementOptions options;
    options.size_m = 0.1;
    const auto exact = places(movement_path(Movement::circle, options, carrier_hz).path);
    options.grid = PositionGrid{};
    const MadeMovement made = movement_path(Movement::circle, options, carrier_hz);
    const auto coarse = places(made.path);
    REQUIRE(coarse.size() == exact.size());
    REQUIRE(made.path.steps.size() < 60);
    for (std::size_t i = 0; i < exact.size(); i += 501) {
        REQUIRE(distance(*coarse[i], *exact[i]) <= 5e-3 * std::numbers::sqrt2 + 1e-12);
        REQUIRE(distance(options.grid->nearest(*coarse[i]), *coarse[i]) < 1e-12);
    }
}

TEST_CASE("movement: measures that make no sense are named", "[hoshi]") {
    REQUIRE_REFUSED(movement_of("square"));
    MovementOptions options;
    options.size_m = 0.0;
    REQUIRE_REFUSED(movement_path(Movement::line, options, carrier_hz));
    options = {};
    options.speed_m_s = std::nan("");
    REQUIRE_REFUSED(movement_path(Movement::line, options, carrier_hz));
    options = {};
    options.speed_m_s = 1000.0;
    REQUIRE_REFUSED(movement_path(Movement::line, options, carrier_hz));
    options = {};
    options.hop_s = 1e-6;
    REQUIRE_REFUSED(movement_path(Movement::random, options, carrier_hz));
    options = {};
    options.centre.x = INFINITY;
    REQUIRE_REFUSED(movement_path(Movement::circle, options, carrier_hz));
}

TEST_CASE("marker: two cameras find a point exactly without noise", "[hoshi]") {
    const MarkerTracker tracker = usual_tracker();
    std::mt19937_64 g(Catch::rngSeed());
    CAPTURE(Catch::rngSeed());
    std::uniform_real_distribution<double> side(-0.09, 0.09), height(0.15, 0.3);
    for (int i = 0; i < 200; ++i) {
        const Vec3 point{side(g), side(g), height(g)};
        const auto left = tracker.first.seen(point), right = tracker.second.seen(point);
        REQUIRE(left);
        REQUIRE(right);
        REQUIRE(distance(triangulated(tracker.first, *left, tracker.second, *right), point) < 1e-12);
    }
    // The camera's own geometry: its target is in the middle, and an object 1/10 as wide as far is f/10 pixels wide.
    const PinholeCamera camera = camera_towards({0, 0, 1.0}, {0, 0, 0}, 2.0 * std::atan(0.5));
    REQUIRE(camera.focal_px == Approx(1024.0));
    REQUIRE(camera.seen({0, 0, 0})->u == Approx(512.0));
    REQUIRE(camera.seen({0, 0, 0})->v == Approx(384.0));
    REQUIRE(camera.seen({0.1, 0, 0})->u == Approx(512.0 + 102.4));
    REQUIRE_FALSE(camera.seen({0, 0, 1.5}));
    REQUIRE_FALSE(camera.seen({0.6, 0, 0}));
    REQUIRE_REFUSED(triangulated(camera, {512, 384}, camera, {512, 384}));
    REQUIRE_THROWS_AS(camera_towards({0, 0, 1}, {0, 0, 1}, 0.5), Error);
    REQUIRE_THROWS_AS(camera_towards({1, 0, 0}, {0, 0, 0}, 0.5), Error);
    REQUIRE_THROWS_AS(camera_towards({0, 0, 1}, {0, 0, 0}, 4.0), Error);
}

TEST_CASE("marker: half a pixel of noise leaves less than a millimetre", "[hoshi]") {
    MarkerTracker tracker = usual_tracker();
    tracker.seed = Catch::rngSeed();
    CAPTURE(Catch::rngSeed());
    double square = 0.0, along = 0.0;
    std::size_t count = 0;
    const Vec3 sight = 0.5 * (tracker.first.forward + tracker.second.forward);
    for (const HandScript script : {HandScript::press, HandScript::slide, HandScript::wave, HandScript::grasp}) {
        const HandRecording recording = recording_of(script, 0.22);
        const MarkerTrack track = track_marker(recording, tracker);
        REQUIRE(track.unseen == 0);
        REQUIRE(track.samples.size() == recording.frames.size());
        for (const MarkerSample& sample : track.samples) {
            const Hand hand = synthetic_hand(script, sample.time_s, 0.22);
            const Vec3 off = sample.position - hand.fingers[2]->joints[0];
            square += dot(off, off);
            along += std::pow(dot(off, sight) / norm(sight), 2);
            ++count;
        }
    }
    const double rms_mm = std::sqrt(square / static_cast<double>(count)) * 1e3;
    // Theory: the depth error of two cameras, range² · √2 · noise / (f · baseline), at about 0.55 to 0.6 m.
    const double depth_mm = std::sqrt(along / static_cast<double>(count)) * 1e3;
    CAPTURE(rms_mm, depth_mm, count);
    REQUIRE(rms_mm < 1.0);
    REQUIRE(depth_mm ==
            Approx(0.58 * 0.58 * std::numbers::sqrt2 * 0.5 / (tracker.first.focal_px * 0.2) * 1e3).epsilon(0.15));
    tracker.noise_px = 0.0;
    const MarkerTrack exact = track_marker(recording_of(HandScript::wave, 0.22), tracker);
    for (const MarkerSample& sample : exact.samples)
        REQUIRE(distance(sample.position, synthetic_hand(HandScript::wave, sample.time_s, 0.22).fingers[2]->joints[0]) <
                1e-9);
    HandRecording none;
    none.frames = {{0.0, {}}, {0.01, {}}};
    REQUIRE_REFUSED(track_marker(none, tracker));
    REQUIRE_REFUSED(track_marker(HandRecording{}, tracker));
    tracker.rate_hz = 0.0;
    REQUIRE_REFUSED(track_marker(none, tracker));
}

TEST_CASE("ball: bounces as a spring and gravity have it, and loses nothing", "[hoshi]") {
    InteractionOptions options = patient();
    const Vec3 palm = from_mm(0, 0, 200);
    const PlayedInteraction played = interact(Content::ball, still(palm, 20.0), options, carrier_hz);
    // Falling from 100 mm, v² = 2gh. Contact under weight: 2/ω·(π − atan(ωv/g)). A bounce every 2v/g + contact.
    const double g = 9.80665, v = std::sqrt(2.0 * g * 0.1), omega = pi / 0.03;
    const double contact = 2.0 / omega * (pi - std::atan(omega * v / g));
    const double period = 2.0 * v / g + contact;
    REQUIRE(played.touches == static_cast<std::size_t>((20.0 + v / g) / period));
    REQUIRE(played.felt_s == Approx(contact * static_cast<double>(played.touches)).epsilon(0.03));
    double highest = 0.0, lowest = 1.0;
    for (const SceneMoment& moment : played.scene) {
        REQUIRE(moment.things.size() == 1);
        if (moment.time_s > 15.0) highest = std::max(highest, moment.things[0].z);
        lowest = std::min(lowest, moment.things[0].z);
    }
    REQUIRE(highest == Approx(0.3).margin(0.6e-3));  // after many bounces it comes as high as it began
    REQUIRE(lowest > 0.18);
    for (const PathStep& step : played.path.steps)
        for (const Focus& focus : step.foci) REQUIRE(distance(focus.position, palm) < 1e-9);
    // A ball that misses the palm, which has moved away, falls anew above it.
    const Vec3 marker = palm - options.palm_from_marker;
    const std::vector<MarkerSample> away{
        {0.0, marker}, {0.05, marker + Vec3{0.1, 0, 0}}, {3.0, marker + Vec3{0.1, 0, 0}}};
    const PlayedInteraction second = interact(Content::ball, away, options, carrier_hz);
    REQUIRE(second.touches > 5);
    for (const PathStep& step : second.path.steps)
        for (const Focus& focus : step.foci) REQUIRE(focus.position.x == Approx(0.1));
}

TEST_CASE("rain: a Poisson process of drops, even over the palm", "[hoshi]") {
    InteractionOptions options = patient();
    options.seed = Catch::rngSeed();
    CAPTURE(Catch::rngSeed());
    options.spacing_m = 0.0;
    const Vec3 palm = from_mm(5, 5, 220);
    const double seconds = 400.0;
    const PlayedInteraction played = interact(Content::rain, still(palm, seconds), options, carrier_hz);
    const auto touches = static_cast<double>(played.touches);
    REQUIRE(std::abs(touches - 5.0 * seconds) < 6.0 * std::sqrt(5.0 * seconds));
    // Bursts of 30 ms overlap now and then: some burst plays for 1 − e^(−0.15) of the time.
    REQUIRE(played.felt_s / seconds == Approx(1.0 - std::exp(-0.15)).epsilon(0.15));
    double square = 0.0, count = 0.0;
    Vec3 mean;
    for (const PathStep& step : played.path.steps)
        for (const Focus& focus : step.foci) {
            const Vec3 off = focus.position - palm;
            REQUIRE(norm(off) <= 0.04 + 1e-9);
            square += dot(off, off);
            mean = mean + off;
            count += 1.0;
        }
    REQUIRE(square / count == Approx(0.5 * 0.04 * 0.04).epsilon(0.12));  // of an even disc
    REQUIRE(norm(mean) / count < 6.0 * 0.02 / std::sqrt(count));
}

TEST_CASE("creature: walks at its speed and stays on the palm", "[hoshi]") {
    InteractionOptions options = patient();
    options.seed = Catch::rngSeed();
    CAPTURE(Catch::rngSeed());
    // On a palm that moves, too: the creature moves with it.
    const Vec3 marker = from_mm(0, 45, 200);
    std::vector<MarkerSample> moving;
    for (int i = 0; i <= 600; ++i)
        moving.push_back({0.1 * i, marker + 0.02 * Vec3{std::sin(0.1 * i), std::cos(0.07 * i), 0.0}});
    const PlayedInteraction played = interact(Content::creature, moving, options, carrier_hz);
    REQUIRE(played.felt_s == Approx(60.0).margin(2e-3));
    double walked = 0.0, farthest = 0.0;
    for (std::size_t i = 0; i < played.scene.size(); ++i) {
        const Vec3 on_palm = played.scene[i].things.front() - *played.scene[i].palm;
        farthest = std::max(farthest, norm(on_palm));
        if (i > 0) walked += distance(on_palm, played.scene[i - 1].things.front() - *played.scene[i - 1].palm);
        REQUIRE(distance(*played.scene[i].focus, played.scene[i].things.front()) <= options.spacing_m);
    }
    REQUIRE(walked == Approx(0.03 * 60.0).epsilon(0.01));
    REQUIRE(farthest <= 0.04);
    REQUIRE(farthest > 0.01);
    options.grid = interaction_grid();
    for (const PathStep& step : interact(Content::creature, moving, options, carrier_hz).path.steps)
        for (const Focus& focus : step.foci)
            REQUIRE(distance(options.grid->nearest(focus.position), focus.position) < 1e-12);
}

TEST_CASE("interaction: out of reach, lost hands and bad recordings are told", "[hoshi]") {
    InteractionOptions options = patient();
    const PlayedInteraction low = interact(Content::creature, still(from_mm(0, 0, 140), 2.0), options, carrier_hz);
    REQUIRE(low.felt_s == 0.0);
    REQUIRE(low.out_of_range_s == Approx(2.0));
    for (const PathStep& step : low.path.steps) REQUIRE(step.foci.empty());
    options.grid = interaction_grid();
    REQUIRE(interact(Content::creature, still(from_mm(200, 0, 200), 1.0), options, carrier_hz).felt_s == 0.0);
    // A gap of half a second in a recording of two seconds is silent.
    options = {};
    std::vector<MarkerSample> gap;
    for (int i = 0; i <= 200; ++i)
        if (i <= 50 || i >= 100) gap.push_back({0.01 * i, from_mm(0, 45, 200)});
    const PlayedInteraction lost = interact(Content::creature, gap, options, carrier_hz);
    REQUIRE(lost.lost_s == Approx(0.5).margin(2e-3));
    REQUIRE(lost.felt_s == Approx(1.5).margin(2e-3));
    REQUIRE_REFUSED(interact(Content::ball, std::vector<MarkerSample>{{}}, options, carrier_hz));
    REQUIRE_REFUSED(interact(Content::ball, std::vector<MarkerSample>{{}, {}}, options, carrier_hz));
    REQUIRE_REFUSED(
        interact(Content::ball, std::vector<MarkerSample>{{0, {std::nan(""), 0, 0}}, {1, {}}}, options, carrier_hz));
    options.rain_hz = 0.0;
    REQUIRE_REFUSED(interact(Content::rain, gap, options, carrier_hz));
    REQUIRE_REFUSED(content_of("snow"));
}
