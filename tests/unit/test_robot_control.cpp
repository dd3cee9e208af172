// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/plant.hpp"
#include "haptogram/robot/robot_file.hpp"
#include "haptogram/robot/simulate.hpp"
#include "haptogram/robot/tension.hpp"
#include "haptogram/robot/workspace.hpp"

using namespace haptogram;
using namespace haptogram::robot;

namespace {

/// Places of the virtual body under a force along z for three seconds, at these times, mm.
std::vector<double> admitted(double force_n, const std::vector<double>& times_s) {
    const AdmittanceOptions options;
    AdmittanceState state;
    std::vector<double> places;
    for (int i = 0; places.size() < times_s.size(); ++i) {
        const double time = i * options.period_s;
        if (time >= times_s[places.size()] - 1e-9) places.push_back(state.place[2] * 1e3);
        Wrench wrench = Wrench::Zero();
        if (time < 3.0 - 1e-9) wrench[2] = force_n;
        state = admit(state, wrench, options);
    }
    return places;
}

SimulationOptions pushed(const std::string& push, double duration_s) {
    SimulationOptions options;
    options.geometry = find_geometry();
    options.user = pushing_user(push.empty() ? std::vector<Push>{} : std::vector<Push>{parse_push(push)});
    options.duration_s = duration_s;
    return options;
}

double height_at(const Simulation& simulation, double time_s) {
    for (const TraceRow& row : simulation.rows)
        if (row.time_s >= time_s - 1e-6) return row.position.z() * 1e3;
    return NAN;
}

bool has(const Simulation& simulation, Event::Kind kind, int cable) {
    for (const Event& event : simulation.events)
        if (event.kind == kind && event.cable == cable) return true;
    return false;
}

}  // namespace

TEST_CASE("robot: the zones' story, to the printed digits", "[robot][admittance]") {
    const std::vector<double> times = {3.0, 12.0};
    const auto four = admitted(4, times), five = admitted(5, times), eight = admitted(8, times),
               ten = admitted(10, times);
    CHECK(four[0] == Approx(26.67).margin(0.005));
    CHECK(four[1] == Approx(0.0).margin(0.0005));
    CHECK(five[0] == Approx(132.5).margin(0.05));
    CHECK(eight[0] == Approx(140.0).margin(0.05));
    CHECK(ten[0] == Approx(145.0).margin(0.05));
    CHECK(five[1] == Approx(102.0).margin(0.05));
    CHECK(eight[1] == Approx(91.2).margin(0.05));
    CHECK(ten[1] == Approx(84.0).margin(0.05));
    // The barrier is 6 N when it is approached slowly.
    const Zones zones;
    CHECK(zones.force({0, 0, 0.040}).z() == Approx(-6.0));
    CHECK(zones.force({0.03, 0, 0.04 * 0.9999}).norm() == 0.0);
    CHECK(zones.force({0, -0.13, 0}).y() == Approx(4.0));
    CHECK(zones.zone({0, 0, 0.03}) == 1);
    CHECK(zones.zone({0, 0.1, 0}) == 2);
    CHECK(zones.zone({0.15, 0, 0}) == 3);
    CHECK(zones.zone({0.17, 0, 0}) == 4);
}

TEST_CASE("robot: a mass and damper beside its closed form, and the limit of stability", "[robot][admittance]") {
    // In Z2 no spring acts: v(t) = v0·e^{−Dt/I}, which the semi-implicit step makes (1 + TD/I)^{−n}.
    AdmittanceOptions options;
    AdmittanceState state;
    state.place[0] = 0.06;
    state.velocity[0] = 0.1;
    for (int i = 1; i <= 20; ++i) {
        state = admit(state, Wrench::Zero(), options);
        REQUIRE(state.velocity[0] == Approx(0.1 * std::pow(1.3, -i)).epsilon(1e-12));
    }
    const auto grows = [](double stiffness) {
        AdmittanceOptions springy;
        springy.damping_n_s_m = 0.0;
        springy.zones.inner_n_m = stiffness;
        springy.zones.inner_m = 1e12;
        AdmittanceState body;
        body.place[0] = 1e-6;
        double largest = 0.0;
        for (int i = 0; i < 1000; ++i) {
            body = admit(body, Wrench::Zero(), springy);
            largest = std::max(largest, std::abs(body.place[0]));
        }
        return largest > 1.0;
    };
    CHECK_FALSE(grows(4400.0));
    CHECK(grows(4500.0));
    options.zones.inner_n_m = 4500.0;
    REQUIRE_REFUSED(require_sound(options));
    options = {};
    options.zones.middle_m = 0.03;
    REQUIRE_REFUSED(require_sound(options));
}

TEST_CASE("robot: the encoder's and the converter's steps", "[robot][plant]") {
    const DriveOptions drives;
    REQUIRE(drives.metres_per_count() * 1e6 == Approx(7.140).margin(0.0005));
    REQUIRE(4 * drives.metres_per_count() * 1e6 == Approx(28.56).margin(0.005));
    REQUIRE(drives.largest_code() == 2047);
    Plant plant(find_geometry(), {}, {}, {});
    std::array<std::int16_t, cable_count> codes{};
    codes[3] = 2048;
    REQUIRE_REFUSED(plant.command(codes));
    REQUIRE_REFUSED(Plant({find_geometry()}, {}, {{0.3, 0, 0}, Matrix3::Identity()}, {}));
    REQUIRE_REFUSED(plant.break_cable(8));
}

TEST_CASE("robot: a plant without cables falls as a stone, and with them keeps its energy", "[robot][plant]") {
    Plant falling(find_geometry(), {}, {}, {});
    for (int i = 0; i < cable_count; ++i) falling.break_cable(i);
    falling.advance(0.1);
    REQUIRE(falling.pose().position.z() == Approx(-0.5 * gravity_m_s2 * 0.01).epsilon(0.001));
    REQUIRE(falling.velocity().z() == Approx(-gravity_m_s2 * 0.1).epsilon(1e-9));
    // Constant pulls that balance the weight: nothing moves but by the codes' rounding.
    Plant resting(find_geometry(), {}, {}, {});
    resting.advance(0.2);
    REQUIRE(resting.pose().position.norm() < 1e-6);
    REQUIRE(resting.least_tensions().minCoeff() > 3.4);
}

TEST_CASE("robot: the zones on the simulated plant, within half a millimetre", "[robot][simulate]") {
    struct Row {
        double force, held, after;
    };
    for (const Row& row : {Row{4, 26.67, 0.0}, Row{5, 132.5, 102.0}, Row{8, 140.0, 91.2}, Row{10, 145.0, 84.0}}) {
        CAPTURE(row.force);
        const Simulation found = simulate(pushed("0:3:0,0," + std::to_string(row.force), 12.0));
        REQUIRE(found.events.empty());
        CHECK(height_at(found, 2.97) == Approx(row.held).margin(0.5));
        CHECK(height_at(found, 12.0) == Approx(row.after).margin(0.5));
        if (row.force > 4) {
            CHECK(height_at(found, 4.5) == Approx(row.after).margin(0.5));
            CHECK(height_at(found, 12.0) == Approx(height_at(found, 4.5)).margin(0.03));  // no drift in Z2
        }
        // The controller's force is the user's.
        CHECK(found.rows[90].measured.z() == Approx(row.force).margin(0.1));
    }
    // The geometry must reach what 10 N overshoot to.
    SimulationOptions options = pushed("0:3:0,0,10", 2.0);
    options.record_s = 0.001;
    double highest = 0.0;
    for (const TraceRow& row : simulate(options).rows) highest = std::max(highest, row.position.z() * 1e3);
    CHECK(highest == Approx(172.0).margin(0.5));
}

TEST_CASE("robot: return, break-through, coasting and snap in one run", "[robot][simulate]") {
    SimulationOptions options = pushed("", 24.0);
    // 8.01 s are whole periods. A release two thirds into one moves the virtual body once more, and it coasts to 92.0.
    options.user = pushing_user({parse_push("1:3:0,0,3"), parse_push("5:8.01:0,0,8"), parse_push("12:12.6:0,0,-1")});
    const Simulation found = simulate(options);
    REQUIRE(found.events.empty());
    CHECK(height_at(found, 3.0) == Approx(20.0).margin(0.5));   // 3 N over 150 N/m: not out of Z1
    CHECK(height_at(found, 5.0) == Approx(0.0).margin(0.5));    // and back
    CHECK(height_at(found, 8.0) == Approx(140.0).margin(0.5));  // through Z2 into Z3
    CHECK(height_at(found, 12.0) == Approx(91.2).margin(0.5));  // guided back, and coasting in Z2
    CHECK(std::abs(height_at(found, 24.0)) < 0.5);              // drawn towards Z1, which catches it
    double fastest = 0.0;
    for (const TraceRow& row : found.rows)
        if (row.time_s > 12.0) fastest = std::max(fastest, std::abs(row.velocity.z()));
    CHECK(fastest > 0.13);  // 1 N moves it at 0.1 m/s at most, D being 10 N·s/m: Z1 snaps
}

TEST_CASE("robot: ten minutes of a wandering hand without slack or limit cycle", "[robot][simulate]") {
    SimulationOptions options = pushed("", 600.0);
    options.plant.seed = Catch::rngSeed();
    const User hand = wandering_user({}, 0.060, Catch::rngSeed());
    // The hand stands still in the end, so that what goes on moving is the robot.
    options.user = {hand.mass_kg, [hand](double time, const Vector3& position, const Vector3& velocity) {
                        return hand.force(std::min(time, 590.0), position, velocity);
                    }};
    options.record_s = 0.3;
    const Simulation found = simulate(options);
    double moved = 0.0, force = 0.0;
    for (const TraceRow& row : found.rows) {
        moved = std::max(moved, row.position.norm());
        force = std::max(force, row.user.norm());
    }
    INFO("least tension " << found.least_n.minCoeff() << " N, steady to " << found.steadiness_m * 1e3 << " mm, moved "
                          << moved * 1e3 << " mm by " << force << " N");
    for (const Event& event : found.events) UNSCOPED_INFO(event.text);
    CHECK(found.events.empty());
    CHECK(found.least_n.minCoeff() >= 0.5);
    CHECK(found.most_n.maxCoeff() <= 10.0);
    CHECK(found.steadiness_m < 0.5e-3);
    CHECK(moved > 0.01);
}

TEST_CASE("robot: an encoder that slips and a sensor that is lost are named, and the handle rests", "[robot][faults]") {
    for (int cable = 0; cable < cable_count; ++cable)
        for (const std::string kind : {"slip", "lost", "frozen"}) {
            CAPTURE(cable, kind);
            SimulationOptions options = pushed("", 4.0);
            options.faults = {parse_fault(kind + ":" + std::to_string(cable + 1) + ":2")};
            const Simulation found = simulate(options);
            REQUIRE(found.events.size() == 1);
            CHECK(found.events[0].cable == cable);
            CHECK(found.events[0].kind == (kind == "slip" ? Event::Kind::encoder_slip : Event::Kind::sensor_lost));
            CHECK(found.events[0].time_s < 2.06);
            CHECK(found.steadiness_m < 0.1e-3);
            CHECK(found.rows.back().position.norm() < 1e-3);
            CHECK(found.least_n.minCoeff() >= 0.5);
        }
    // A slip below what one jump shows is seen in the lengths, which then fit no pose.
    SimulationOptions options = pushed("", 4.0);
    for (int i = 0; i < 4; ++i) {
        Fault fault = parse_fault("slip:4:2");
        fault.metres = 0.0008;
        fault.time_s += 0.1 * i;
        options.faults.push_back(fault);
    }
    const Simulation slow = simulate(options);
    REQUIRE(has(slow, Event::Kind::encoder_slip, -1));
    CHECK(slow.events[0].text.find("fit no pose") != std::string::npos);
    CHECK(slow.steadiness_m < 0.2e-3);
}

TEST_CASE("robot: a broken cable is named, and the other seven bring the handle to rest", "[robot][faults]") {
    for (int cable = 0; cable < cable_count; ++cable) {
        CAPTURE(cable);
        SimulationOptions options = pushed("", 5.0);
        options.faults = {parse_fault("broken:" + std::to_string(cable + 1) + ":2")};
        const Simulation found = simulate(options);
        CHECK(has(found, Event::Kind::slack, cable));
        CHECK(has(found, Event::Kind::broken, cable));
        CHECK(found.events[0].time_s < 2.01);
        CHECK(found.steadiness_m < 0.1e-3);
        CHECK(found.events.size() == 2);
        CHECK(found.rows.back().position.norm() < 0.06);  // led to where seven can hold it
        CHECK(found.rows.back().turn.norm() < 0.01);      // upright, and on the way by no more than
        for (const TraceRow& row : found.rows) CHECK(row.turn.norm() < 18 * std::numbers::pi / 180);
    }
}

TEST_CASE("robot: far from home seven cables cannot hold a handle without a hand, and that is said",
          "[robot][faults]") {
    for (const int cable : {1, 3, 5, 7}) {
        CAPTURE(cable);
        SimulationOptions options = pushed("0:2:0,0,5", 9.0);  // it rests at 102 mm
        options.faults = {parse_fault("broken:" + std::to_string(cable + 1) + ":5")};
        const Simulation found = simulate(options);
        CHECK(has(found, Event::Kind::cannot_hold, -1));
        CHECK(found.most_turn_rad > 1.0);
        CHECK(found.steadiness_m < 0.1e-3);
    }
}

TEST_CASE("robot: a cable breaks under a hand that goes on moving, and the handle comes to rest", "[robot][faults]") {
    int too_strong = 0;
    for (int cable = 0; cable < cable_count; ++cable) {
        const std::uint64_t seed = Catch::rngSeed() + static_cast<std::uint64_t>(cable);
        CAPTURE(cable, seed);
        SimulationOptions options = pushed("", 12.0);
        options.plant.seed = seed;
        const User hand = wandering_user({}, 0.060, seed);
        // The hand stands still in the end, so that what goes on moving is the robot.
        options.user = {hand.mass_kg, [hand](double time, const Vector3& position, const Vector3& velocity) {
                            return hand.force(std::min(time, 10.0), position, velocity);
                        }};
        options.faults = {parse_fault("broken:" + std::to_string(cable + 1) + ":4")};
        options.record_s = 0.01;
        const Simulation found = simulate(options);
        for (const Event& event : found.events) UNSCOPED_INFO(event.time_s << " s: " << event.text);
        CHECK(has(found, Event::Kind::slack, cable));
        CHECK(has(found, Event::Kind::broken, cable));
        CHECK(found.events[0].time_s < 4.01);
        const bool strong = has(found, Event::Kind::cannot_hold, -1);
        too_strong += strong ? 1 : 0;
        double turn = 0.0, fastest = 0.0, pulled = 0.0, at_rest = 0.0;
        for (const TraceRow& row : found.rows) {
            if (row.time_s > 4.0) turn = std::max(turn, row.turn.norm());
            if (row.time_s > 4.0) fastest = std::max(fastest, row.velocity.norm());
            if (row.time_s > 5.5) pulled = std::max(pulled, row.velocity.norm());
            if (row.time_s > 11.5) at_rest = std::max(at_rest, row.velocity.norm());
        }
        INFO("turned by " << turn * 180 / std::numbers::pi << " degrees, " << fastest << " m/s, pulled " << pulled
                          << ", at rest " << at_rest);
        CHECK(turn < 3 * std::numbers::pi / 180);
        CHECK(fastest < 0.5);
        // It gives way a little while the hand pulls now more and now less, and not at all when that stands still.
        CHECK(pulled < (strong ? 0.25 : 0.06));
        CHECK(at_rest < 0.005);
        CHECK(found.steadiness_m < 0.5e-3);
        CHECK(found.most_n.maxCoeff() < 30.0);  // for a moment, when it breaks
    }
    CHECK(too_strong <= 3);
}

TEST_CASE("robot: a hand that is stronger than seven cables is said, and does not turn the handle over",
          "[robot][faults]") {
    for (const int cable : {0, 1, 6}) {
        CAPTURE(cable);
        SimulationOptions options = pushed("", 9.0);
        options.user = wandering_user({0.5, 15.0, 300.0}, 0.060, 10 + static_cast<std::uint64_t>(cable));
        options.faults = {parse_fault("broken:" + std::to_string(cable + 1) + ":3")};
        options.record_s = 0.01;
        const Simulation found = simulate(options);
        REQUIRE(has(found, Event::Kind::cannot_hold, -1));
        CHECK(found.events.back().text.find("stronger than the cables") != std::string::npos);
        for (const TraceRow& row : found.rows) {
            if (row.time_s < 3.0) continue;
            REQUIRE(row.turn.norm() < 15 * std::numbers::pi / 180);
            REQUIRE(row.velocity.norm() < 0.6);
        }
    }
    // A force without a hand's inertia that goes on pushing turns it over. The motors wind in until nothing moves.
    for (const int cable : {3, 5}) {
        CAPTURE(cable);
        SimulationOptions options = pushed("0:20:2,0,-3", 8.0);
        options.faults = {parse_fault("broken:" + std::to_string(cable + 1) + ":2")};
        const Simulation found = simulate(options);
        REQUIRE(has(found, Event::Kind::cannot_hold, -1));
        CHECK(found.rows.back().turn.norm() > 0.35);
        CHECK(found.steadiness_m < 2e-3);
        CHECK(found.fastest_end_m_s < 0.1);
    }
}

TEST_CASE("robot: the wrench of seven cables that is nearest to a wanted one", "[robot][faults]") {
    const Geometry geometry = find_geometry();
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> part(-1.0, 1.0), tension(0.5, 10.0);
    for (int run = 0; run < 200; ++run) {
        CablesLeft left;
        left.fill(true);
        const int gone = static_cast<int>(random() % cable_count);
        left[static_cast<std::size_t>(gone)] = false;
        const Pose pose{0.06 * Vector3(part(random), part(random), part(random)),
                        rotation_of(0.1 * Vector3(part(random), part(random), part(random)))};
        const Structure structure = structure_of(geometry, pose);
        Wrench wanted;
        wanted << 15.0 * Vector3(part(random), part(random), part(random)),
            0.2 * Vector3(part(random), part(random), part(random));
        // As the controller does: each search begins where the last one ended.
        PerCable found = PerCable::Zero();
        for (int again = 0; again < 20; ++again) found = nearest_tensions(structure, wanted, 0.5, 10.0, left, found);
        const auto off = [&](const PerCable& tensions) {
            Wrench difference = structure * tensions - wanted;
            difference.tail<3>() /= 0.010;
            return difference.squaredNorm();
        };
        REQUIRE(found[gone] == 0.0);
        // No other tensions within the limits come nearer; what they gain, the middle of the limits may cost.
        const double best = off(found);
        for (int other = 0; other < 300; ++other) {
            PerCable tried = found;
            const double size = other % 3 == 0 ? 5.0 : other % 3 == 1 ? 0.5 : 0.05;
            for (int i = 0; i < cable_count; ++i)
                if (i != gone) tried[i] = std::clamp(found[i] + size * part(random), 0.5, 10.0);
            REQUIRE(off(tried) > best - 0.1);
        }
        for (int i = 0; i < cable_count; ++i)
            if (i != gone) REQUIRE((found[i] >= 0.5 && found[i] <= 10.0));
        // A wrench that they can make, they make.
        PerCable made = PerCable::Zero();
        for (int i = 0; i < cable_count; ++i)
            if (i != gone) made[i] = tension(random);
        wanted = structure * made;
        for (int again = 0; again < 200; ++again) found = nearest_tensions(structure, wanted, 0.5, 10.0, left, found);
        REQUIRE(off(found) < 0.1);  // 0.3 N or 3 mN·m: what the middle of the limits may cost
    }
}

TEST_CASE("robot: what seven cables hold in every direction, and where", "[robot][faults]") {
    const Geometry geometry = find_geometry();
    const auto without = [](int cable) {
        CablesLeft left;
        left.fill(true);
        left[static_cast<std::size_t>(cable)] = false;
        return left;
    };
    const auto held = [&](double x, double y, double z, int cable) {
        return force_held(geometry, {Vector3(x, y, z) * 1e-3, Matrix3::Identity()}, without(cable)).value_or(-1.0);
    };
    // By linear programs, solved with scipy.
    CHECK(held(60, 20, 40, 0) == Approx(5.510).margin(0.06));
    CHECK(held(20, 60, -60, 1) == Approx(5.514).margin(0.06));
    CHECK(held(0, 0, 0, 0) == -1.0);
    CHECK(held(-60, -20, -40, 0) == -1.0);
    // All eight at the centre hold 12.49 N along x and y (largest_wrench), and less towards some corner.
    CablesLeft all;
    all.fill(true);
    double least = 1e9;
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                Wrench direction = Wrench::Zero();
                direction.head<3>() = Vector3(x, y, z).normalized();
                least = std::min(least, largest_wrench(geometry, {}, direction).value());
            }
    CHECK(force_held(geometry, {}, all).value() == Approx(least).margin(0.06));
    for (int cable = 0; cable < cable_count; ++cable) {
        const auto place = refuge(geometry, {}, without(cable), 2.5);
        REQUIRE(place);
        CHECK(force_held(geometry, *place, without(cable)).value() >= 2.5);
        CHECK(place->position.norm() > 0.0399);
        CHECK(place->position.norm() < 0.0501);
        // Away from where the lost cable pulled.
        CHECK(place->position.dot(geometry.anchors[static_cast<std::size_t>(cable)]) < 0.0);
    }
    CHECK_FALSE(refuge(geometry, {Vector3(0, 0, 5), Matrix3::Identity()}, without(0), 2.5));
}

TEST_CASE("robot: a command out of reach is said, and the handle rests", "[robot][faults]") {
    SimulationOptions options = pushed("0.5:6:5,5,0", 6.0);
    options.controller.admittance.zones = {1e-6, 0.5, 0.6, 0.0, 0.0};  // nothing holds the virtual body back
    const Simulation out = simulate(options);
    for (const Event& event : out.events) UNSCOPED_INFO(event.time_s << " s: " << event.text);
    REQUIRE(out.events.size() == 1);
    CHECK(out.events[0].kind == Event::Kind::out_of_reach);
    CHECK(out.events[0].text.find("out of reach") != std::string::npos);
    CHECK(out.steadiness_m < 0.5e-3);
}

TEST_CASE("robot: motors yield to a user who is too strong, and bring the handle back", "[robot][faults]") {
    // Forces that eight cables of 10 N cannot hold: 12.5 N to the side, 21.7 N upwards.
    struct Row {
        const char* push;
        double most_n, most_off_m;
    };
    for (const Row& row :
         {Row{"1:2:20,0,0", 17.0, 0.15}, Row{"1:2:0,0,30", 19.0, 0.21}, Row{"1:2:0,0,-30", 22.0, 0.26}}) {
        CAPTURE(row.push);
        const Simulation heavy = simulate(pushed(row.push, 5.0));
        for (const Event& event : heavy.events) UNSCOPED_INFO(event.time_s << " s: " << event.text);
        REQUIRE(heavy.events.size() == 1);  // no encoder slips, no cable is slack
        CHECK(heavy.events[0].kind == Event::Kind::overload);
        CHECK(heavy.events[0].time_s < 1.1);
        CHECK(heavy.events[0].text.find("N that way are the most") != std::string::npos);
        CHECK(heavy.most_off_m == Approx(row.most_off_m).margin(0.01));
        CHECK(heavy.most_n.maxCoeff() ==
              Approx(row.most_n).margin(1.0));  // the motors' 10 N, and what their inertia adds
        CHECK(heavy.rows.back().position.norm() < 2e-3);
        CHECK(heavy.rows.back().turn.norm() < 0.02);
        CHECK(heavy.steadiness_m < 0.2e-3);
    }
    // 30 N to the side throw the handle to where no tensions hold it upright. It turns over, cables hang and are jerked
    // by the speed v at which they are taut again: by about v·√(k·m), 60 N at 1 m/s, where the motors hold 5.
    for (const char* push : {"1:2:30,0,0", "1:2:0,30,0", "1:1.1:30,0,0", "1:2:20,20,0"}) {
        CAPTURE(push);
        const Simulation thrown = simulate(pushed(push, 6.0));
        REQUIRE(thrown.events.size() == 1);
        CHECK(thrown.events[0].kind == Event::Kind::overload);
        CHECK(thrown.most_off_m > 0.15);
        CHECK(thrown.most_off_m < 0.32);
        CHECK(thrown.most_turn_rad > 1.5);
        CHECK(thrown.most_n.maxCoeff() < 65.0);
        CHECK(thrown.touched_s > 0.0);
        CHECK(thrown.nearest.room_m < 0.0);
        CHECK(thrown.rows.back().position.norm() < 2e-3);
        CHECK(thrown.rows.back().turn.norm() < 0.02);
    }
    const Geometry geometry = find_geometry();
    const double cable_n_m = PlantOptions{}.cable_n / cable_lengths(geometry, {})[0];
    const double motor_kg = ControllerOptions{}.drive_kg;
    const double together_kg = geometry.mass_kg * motor_kg / (geometry.mass_kg + motor_kg);
    CHECK(std::sqrt(cable_n_m * together_kg) == Approx(60.0).margin(3.0));
}

TEST_CASE("robot: the codes for the motors never ask for more than the largest tension", "[robot][faults]") {
    const Geometry geometry = find_geometry();
    const ControllerOptions options;
    Controller controller(geometry, options, {});
    std::array<DriveReading, cable_count> readings;
    for (DriveReading& reading : readings) reading.tension_n = 3.5;
    const double most = geometry.most_n / options.drives.newtons_per_code();
    for (int tick = 0; tick < 200; ++tick) {
        for (std::size_t i = 0; i < readings.size(); ++i) readings[i].counts += i < 4 ? 100 : -100;  // 0.7 m/s
        for (const std::int16_t code : controller.step(readings)) REQUIRE(code <= std::lround(most));
    }
}

TEST_CASE("robot: a run tells its least room, and refuses a robot whose cables meet", "[robot][simulate]") {
    const Simulation calm = simulate(pushed("0:1:0,0,4", 1.0));
    CHECK(calm.touched_s == 0.0);
    CHECK(calm.nearest.room_m > 0.005);
    CHECK(calm.most_off_m < 0.015);  // what the servos lag behind a step of the force
    SimulationOptions options = pushed("", 1.0);
    options.geometry = load_geometry(test_data() + "/robots/crossing.toml");
    REQUIRE_REFUSED(simulate(options));
}

TEST_CASE("robot: the same options give the same trace", "[robot][simulate]") {
    const SimulationOptions options = pushed("0.2:1:1,2,3", 1.5);
    const std::string first = to_csv(simulate(options));
    REQUIRE(first == to_csv(simulate(options)));
    SimulationOptions other = options;
    other.plant.seed = 2;
    REQUIRE(first != to_csv(simulate(other)));
}

TEST_CASE("robot: pushes and faults as a user writes them", "[robot][simulate]") {
    const Push push = parse_push("1:4.5:0,-2,8");
    REQUIRE(push.from_s == 1.0);
    REQUIRE(push.to_s == 4.5);
    REQUIRE(push.force == Vector3(0, -2, 8));
    for (const char* bad : {"", "1:4", "4:1:0,0,8", "1:4:0,8", "1:4:0,0,x", "-1:4:0,0,8", "1:4:0,0,8 "})
        REQUIRE_REFUSED(parse_push(bad));
    const Fault fault = parse_fault("slip:8:2.5");
    REQUIRE(fault.kind == Fault::Kind::slip);
    REQUIRE(fault.cable == 7);
    for (const char* bad : {"", "burnt:1:2", "lost:0:2", "lost:9:2", "lost:1.5:2", "lost:1:-2", "lost:1"})
        REQUIRE_REFUSED(parse_fault(bad));
    REQUIRE_REFUSED(check_output_path("x.gif"));
    REQUIRE_REFUSED(simulate(pushed("", 0.0)));
}
