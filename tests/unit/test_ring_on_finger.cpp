// SPDX-License-Identifier: Apache-2.0
// The sound on fingers: its table against the series of a rigid cylinder and against boundary elements anew, and what
// rings become by it.
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/bessel_prime.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "../refusal.hpp"
#include "haptogram/array/rig.hpp"
#include "haptogram/hand/ring.hpp"
#include "haptogram/scattering/skin.hpp"

using namespace haptogram;
using namespace haptogram::scattering;
using Catch::Contains;

namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Total pressure on a rigid cylinder without end over that of the plane wave that meets it at right angles; the angle
/// between the place and the source.
Complex cylinder_series(double ka, double turn) {
    Complex sum, power = 1.0;
    for (int n = 0; n < 30; ++n, power *= Complex(0, 1)) {
        const Complex slope(boost::math::cyl_bessel_j_prime(n, ka), -boost::math::cyl_neumann_prime(n, ka));
        sum += (n == 0 ? 1.0 : 2.0) * power * Complex(0, -2.0) / (pi * ka * slope) * std::cos(n * turn);
    }
    return sum / std::polar(1.0, ka * std::cos(turn));
}

constexpr double radius = 8e-3;

/// A finger that lies, and the ten places around its middle.
struct Lying {
    FingerForm finger;
    std::vector<Vec3> places;
};
Lying lying(Vec3 middle, Vec3 to_hand, double long_m = 30e-3) {
    Lying made{{middle - long_m * to_hand, to_hand, radius}, {}};
    const auto contact = contact_of(made.finger, middle, -1.0 * to_hand);
    REQUIRE(contact);
    made.places = ring_points(contact->section, 10);
    return made;
}

}  // namespace

TEST_CASE("finger's sound: far from the tip it is that of a cylinder without end", "[finger]") {
    const FingerSound& table = shipped_finger_sound();
    const std::size_t turns = table.grid().turns, across = (table.grid().tilts - 1) / 2;
    for (const double size : table.grid().sizes) {
        FingerSound::Values slice;
        table.at_way(table.of_size(size), 100.0, slice);
        double apart = 0.0, whole = 0.0;
        for (std::size_t i = 0; i < turns; ++i) {
            const Complex right = cylinder_series(size, pi * static_cast<double>(i) / static_cast<double>(turns - 1));
            apart += std::norm(Complex(slice[across * turns + i]) - right);
            whole += std::norm(right);
        }
        INFO("wave number times radius " << size);
        CHECK(std::sqrt(apart / whole) < 0.06);
    }
}

TEST_CASE("finger's sound: the table is what boundary elements give", "[finger]") {
    const FingerSound& table = shipped_finger_sound();
    FingerSound::Grid grid = table.grid();
    const double size = grid.sizes.front();
    const FingerSound::Values anew = finger_sound_by_elements(grid, size, 6.0), kept = table.of_size(size);
    REQUIRE(anew.size() == kept.size());
    double apart = 0.0, whole = 0.0;
    for (std::size_t i = 0; i < anew.size(); ++i) {
        apart += static_cast<double>(std::norm(anew[i] - kept[i]));
        whole += static_cast<double>(std::norm(kept[i]));
    }
    CHECK(std::sqrt(apart / whole) < 0.04);
}

TEST_CASE("finger's sound: a file that is none is refused by its line", "[finger]") {
    const auto read = [](const std::string& text) { return FingerSound(text, "table"); };
    CHECK_REFUSED(read("sound\n"));
    const std::string head = "haptogram-finger-sound-1\nsizes 1 2\nways 0 1\ntilts 2\nturns 2\n";
    CHECK_REFUSED(read(head + "1 2 3 4\n1 2 3\n"));
    CHECK_REFUSED(read(head + "1 2 3 4\n"));
    CHECK_REFUSED(read("haptogram-finger-sound-1\nsizes 2 1\n"));
}

TEST_CASE("a finger's form follows from how a surface cuts it", "[finger]") {
    struct Case {
        double depth_m;
        Vec3 to_hand;
        double off_deg;  // by which the direction may be wrong
    };
    // A shallow cut is a circle of the round end, which says nothing of the direction.
    const auto [depth_m, to_hand, off_deg] = GENERATE(Case{12e-3, {0, 0, 1}, 5}, Case{4e-3, {0, 0, 1}, 5},
                                                      Case{14e-3, {0, -std::sqrt(0.5), std::sqrt(0.5)}, 12},
                                                      Case{2e-3, {0, -std::sqrt(0.5), std::sqrt(0.5)}, 50});
    const Vec3 at{1e-3, 2e-3, 0.15};
    const FingerForm finger{at + (radius - depth_m) * Vec3{0, 0, 1}, to_hand, radius};
    const auto contact = contact_of(finger, at, {0, 0, -1});
    REQUIRE(contact);
    CHECK(contact->deepest_m == Approx(depth_m));
    const auto form = form_of(*contact);
    REQUIRE(form);
    CAPTURE(depth_m, to_hand.y, form->radius, form->tip.x, form->tip.y, form->tip.z);
    CHECK(form->radius == Approx(radius).epsilon(0.1));
    CHECK(distance(form->tip, finger.tip) < 2.5e-3);
    CHECK(std::acos(dot(form->to_hand, to_hand)) * 180.0 / pi < off_deg);
}

TEST_CASE("one tile from below reaches the underside of a finger that lies, and no more", "[finger]") {
    RingWeigher weigher(find_array("tile-10x10"));
    const Vec3 middle{0, 0, 0.13};
    const Lying ring = lying(middle, {1, 0, 0});
    const auto reach = weigher.weigh(ring.places, ring.finger);
    REQUIRE(reach);
    CHECK(reach->reached >= 3);
    CHECK(reach->reached <= 6);
    for (std::size_t j = 0; j < ring.places.size(); ++j) {
        const bool below = ring.places[j].z < middle.z - 5e-3;
        const bool above = ring.places[j].z > middle.z + 2e-3;
        CAPTURE(j, ring.places[j].z);
        if (above) CHECK(reach->amplitudes[j] == 0.0);
        if (below) CHECK(reach->radiation_pa[j] * std::pow(reach->amplitudes[j], 2) == Approx(reach->even_pa));
    }
}

TEST_CASE("four units around a finger reach its whole ring, unevenly", "[finger]") {
    RingWeigher weigher(joined(find_rig("cube-300")));
    const Lying ring = lying({0, 0, 0.15}, {1, 0, 0});
    const auto reach = weigher.weigh(ring.places, ring.finger);
    REQUIRE(reach);
    CHECK(reach->reached == 10);
    CHECK(reach->uneven > 2.5);
    for (std::size_t j = 0; j < 10; ++j) {
        CHECK(reach->amplitudes[j] <= 1.0);
        CHECK(reach->radiation_pa[j] * std::pow(reach->amplitudes[j], 2) == Approx(reach->even_pa));
    }
    FingerForm thick = ring.finger;
    thick.radius = 20e-3;
    CHECK_FALSE(weigher.weigh(ring.places, thick));
}

TEST_CASE("what a ring becomes is said in words", "[finger]") {
    CHECK_THAT(reach_in_words(find_array("tile-10x10"), {0, 0, 0.15}, 10),
               Contains("from above, 10 of 10 places") && Contains("aslant") && !Contains("does not reach"));
    CHECK_SAID(reach_in_words(find_array("tile-10x10"), {0.3, 0, 0.02}, 10));
}
