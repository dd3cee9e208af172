// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "../refusal.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/live/tasks.hpp"

using namespace haptogram;

namespace {

const Array& cube_of_units() {
    static const Array array = joined(find_rig("cube-300"));
    return array;
}

}  // namespace

TEST_CASE("task: a hidden cube is found by the skin and lifted before four cameras, and no energy comes from nowhere") {
    live::LiftOptions options;
    options.seen = false;
    options.cameras.noise = no_depth_noise;
    options.edge_m = 32e-3;
    options.x_m = 1e-3;
    options.y_m = -5e-3;
    options.turn_deg = -3.0;
    live::LiftReport report;
    for (options.person_seed = 1; options.person_seed <= 6 && !report.done; ++options.person_seed) {
        report = live::lift(cube_of_units(), options);
        CHECK(report.energy_made_j < 2e-5);
        CHECK(report.felt_shots > 0);
    }
    REQUIRE(report.done);
    CHECK(report.time_s > options.hold_s);
    CHECK(report.lifted_m >= options.lift_m);
    // Two fingers that hold 0.1 kg by friction of 0.8 push with its weight over 2 * 0.8 each, and carry it.
    CHECK(report.mean_force_n > 0.1 * 9.8 / 0.8);
    options.edge_m = -1.0;
    CHECK_REFUSED(live::lift(cube_of_units(), options));
}

TEST_CASE("task: skin that feels too little passes by a hidden cube, again and again") {
    live::LiftOptions options;
    options.seen = false;
    options.felt = live::Felt::still;
    options.cameras.noise = no_depth_noise;
    options.at_most_s = 6.0;
    options.sense.contact_m = 0.0;  // no skin adds up
    const live::LiftReport report = live::lift(cube_of_units(), options);
    CHECK_FALSE(report.done);
    CHECK(report.touched_shots > 0);
    CHECK(report.felt_shots == 0);
    CHECK(report.tries > 1);
}

TEST_CASE("task: without squeezing the cube is not lifted, and the trial ends in time") {
    live::LiftOptions options;
    options.cameras.noise = no_depth_noise;
    options.squeeze_m = 0.1e-3;
    options.at_most_s = 1.5;
    const live::LiftReport report = live::lift(cube_of_units(), options);
    CHECK_FALSE(report.done);
    CHECK(report.lifted_m < options.lift_m);
    CHECK(report.shots == 45);
    CHECK(report.most_force_n > 0.0);
}

TEST_CASE("task: angle and height of a surface are found by one finger before one camera") {
    std::mt19937_64 random(Catch::rngSeed());
    live::SurfaceOptions options;
    options.middle = {0, 0, 0.15};
    options.cameras.count = 1;
    options.cameras.noise = no_depth_noise;
    live::draw_surface(options, random);
    INFO(options.angle_deg << " degrees, " << 1e3 * options.height_m << " mm");
    const live::SurfaceReport report = live::find_surface(cube_of_units(), options);
    REQUIRE(report.done);
    CHECK(report.felt_places >= 3);
    CHECK(std::abs(report.angle_error_deg) <= 2.0);
    CHECK(std::abs(report.height_error_m) <= 1e-3);
    CHECK_FALSE(report.guessed);
    options.places = 1;
    CHECK_REFUSED(live::find_surface(cube_of_units(), options));
}

TEST_CASE("task: who feels nothing of a surface guesses") {
    live::SurfaceOptions options;
    options.middle = {0, 0, 0.15};
    options.cameras.count = 1;
    options.sense.emplace();
    options.nothing = true;
    const live::SurfaceReport report = live::find_surface(cube_of_units(), options);
    CHECK_FALSE(report.done);
    CHECK(report.guessed);
    CHECK(report.felt_places == 0);
    CHECK(std::abs(report.angle_deg) <= 45.0);
}

TEST_CASE("task: skin feels what vibrates and is strong enough, about where it is") {
    const Vec3 at{0, 0, 0.15};
    const FingerForm finger{at, {0, 0, 1}, 8e-3};
    const auto contact = contact_of(finger, at, {0, 0, -1});
    REQUIRE(contact);
    const Array& array = cube_of_units();
    const std::optional<Vec3> start;
    Path ring = ring_path({&contact->section, 1}, {&start, 1}, array.carrier_hz);
    std::mt19937_64 random(Catch::rngSeed());
    live::SkinSense sense(array, {});
    for (int look = 0; look < 5; ++look) {
        const auto felt = sense.feel(ring, finger, random);
        REQUIRE(felt);
        CHECK(felt->over_db > 10.0);
        CHECK(distance(felt->place, at) < 9e-3);  // in the finger: the noise is 1.5 mm
    }
    Path weak = ring, steady = ring;
    for (PathStep& step : weak.steps)
        for (Focus& focus : step.foci) focus.amplitude = 0.01;
    for (PathStep& step : steady.steps) step.foci = ring.steps.front().foci;
    CHECK_FALSE(sense.feel(weak, finger, random));
    CHECK_FALSE(sense.feel(steady, finger, random));
}
