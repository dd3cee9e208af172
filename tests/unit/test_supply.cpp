// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "../refusal.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/verbs/supply.hpp"

using namespace haptogram;

TEST_CASE("supply: what ngspice found for a driver, 22 ohms and a resonator of 80 mH, 700 ohms and 2.7 nF",
          "[supply]") {
    // Volts, duty, the driver's ohms, milliwatts of a channel. The circuit has edges and a quality of 29; the formula
    // has neither.
    const auto row = GENERATE(Catch::Generators::table<double, double, double, double>({{12, 0.50, 7, 54.3},
                                                                                        {12, 0.25, 7, 34.9},
                                                                                        {12, 0.10, 7, 18.9},
                                                                                        {12, 0.02, 7, 15.0},
                                                                                        {18, 0.50, 7, 122},
                                                                                        {20, 0.50, 1, 152},
                                                                                        {24, 0.50, 1, 219}}));
    const auto& [volts, duty, driver, milliwatts] = row;
    const Supply one = supply_of({.channels = 1, .volts = volts, .duty = duty, .series_ohm = 22 + driver});
    CHECK(one.all_w * 1e3 == Approx(milliwatts).epsilon(0.05));
    const Supply all = supply_of({.channels = 100, .volts = volts, .duty = duty, .series_ohm = 22 + driver});
    CHECK(all.all_w == Approx(100 * (one.motion_w + one.charge_w)));
    CHECK(all.current_a * volts == Approx(all.all_w));
}

TEST_CASE("supply: settings out of range are named", "[supply]") {
    CHECK_REFUSED(supply_of({.volts = 0}));
    CHECK_REFUSED(supply_of({.duty = 0.6}));
    CHECK_REFUSED(supply_of({.series_ohm = -1}));
}
