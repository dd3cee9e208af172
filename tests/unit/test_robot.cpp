// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include "../real_time.hpp"
#include "../refusal.hpp"
#include "../test_data.hpp"
#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/tension.hpp"
#include "haptogram/robot/workspace.hpp"

using namespace haptogram;
using namespace haptogram::robot;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

/// A robot whose numbers were worked out by other means, and whose cables meet.
Geometry crossing() { return load_geometry(test_data() + "/robots/crossing.toml"); }

/// The least distance of two segments, by trying places on both: 401 × 401, then finer around the best, three times.
double sampled(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
    double best = 1e9, s = 0.5, t = 0.5, span = 0.5;
    for (int round = 0; round < 4; ++round) {
        const double s0 = s, t0 = t;
        for (int i = -200; i <= 200; ++i)
            for (int j = -200; j <= 200; ++j) {
                const double u = std::clamp(s0 + span * i / 200, 0.0, 1.0),
                             v = std::clamp(t0 + span * j / 200, 0.0, 1.0);
                const double apart = ((1 - u) * a + u * b - (1 - v) * c - v * d).norm();
                if (apart < best) best = apart, s = u, t = v;
            }
        span /= 50;
    }
    return best;
}

/// The pose of the printed numbers: (20, −10, 30) mm, R_z(10°)·R_y(−3°)·R_x(5°).
const Pose posed{{0.020, -0.010, 0.030}, rotation_xyz(degree* Vector3(5, -3, 10))};

void require_close(const PerCable& found, const std::array<double, 8>& expected, double margin) {
    for (int i = 0; i < cable_count; ++i) {
        CAPTURE(i);
        REQUIRE(found[i] == Approx(expected[static_cast<std::size_t>(i)]).margin(margin));
    }
}

double angle_between(const Matrix3& a, const Matrix3& b) {
    return (a - b).norm() / std::sqrt(2.0);  // 2·sin of half the angle
}

/// A random pose in the middle of the frame.
Pose random_pose(std::mt19937_64& random) {
    std::uniform_real_distribution<double> place(-0.06, 0.06), turn(-0.25, 0.25);
    Pose pose;
    for (int k = 0; k < 3; ++k) pose.position[k] = place(random);
    pose.rotation = rotation_xyz({turn(random), turn(random), turn(random)});
    return pose;
}

}  // namespace

TEST_CASE("robot: inverse kinematics to the printed digits", "[robot]") {
    const Geometry geometry = crossing();
    require_close(1e3 * cable_lengths(geometry, posed),
                  {371.9725, 328.5584, 379.8956, 344.8191, 343.3661, 313.2198, 366.0095, 314.5641}, 0.00005);
    require_close(1e3 * cable_lengths(geometry, {}),
                  {344.2383, 344.2383, 344.2383, 344.2383, 344.2383, 344.2383, 344.2383, 344.2383}, 0.00005);
    // Eq. 3 of the paper, written out.
    const PerCable lengths = cable_lengths(geometry, posed);
    for (std::size_t i = 0; i < 8; ++i) {
        const Vector3 &a = geometry.anchors[i], rb = posed.rotation * geometry.attachments[i], &r = posed.position;
        REQUIRE(lengths[static_cast<int>(i)] ==
                Approx(std::sqrt(r.dot(r) + rb.dot(rb) + a.dot(a) - 2 * r.dot(a) + 2 * r.dot(rb) - 2 * rb.dot(a)))
                    .epsilon(1e-13));
    }
    REQUIRE_SAID(out_of_length(geometry, cable_lengths(geometry, {{0.1, 0.1, 0.3}, Matrix3::Identity()})));
}

TEST_CASE("robot: rotations", "[robot]") {
    const Vector3 angles(0.1, -0.2, 0.3);
    const auto about = [](int axis, double angle) {
        Matrix3 m = Matrix3::Identity();
        const int i = (axis + 1) % 3, j = (axis + 2) % 3;
        m(i, i) = m(j, j) = std::cos(angle);
        m(i, j) = -std::sin(angle);
        m(j, i) = std::sin(angle);
        return m;
    };
    const Matrix3 expected = about(2, 0.3) * about(1, -0.2) * about(0, 0.1);
    REQUIRE((rotation_xyz(angles) - expected).norm() < 1e-15);
    REQUIRE((angles_xyz(expected) - angles).norm() < 1e-15);
    REQUIRE((rotation_of(vector_of(expected)) - expected).norm() < 1e-14);
    REQUIRE((rotation_of({0, 0, 0.3}) - about(2, 0.3)).norm() < 1e-15);
}

TEST_CASE("robot: forward kinematics from the centre in five steps at most", "[robot]") {
    const Geometry geometry = crossing();
    const Forward found = forward(geometry, cable_lengths(geometry, posed));
    INFO("steps " << found.steps);
    for (const double cost : found.costs) UNSCOPED_INFO("f " << cost);
    REQUIRE(found.steps <= 5);
    REQUIRE((found.pose.position - posed.position).norm() < 1e-14);
    REQUIRE(angle_between(found.pose.rotation, posed.rotation) < 1e-13);
    REQUIRE(found.costs.size() == static_cast<std::size_t>(found.steps) + 1);
    REQUIRE(found.costs[0] == Approx(1.1e-3).epsilon(0.05));
    REQUIRE(found.costs[1] == Approx(9.0e-8).epsilon(0.05));
    REQUIRE(found.costs[2] == Approx(1.0e-13).epsilon(0.1));
    REQUIRE(found.costs[3] < 1e-24);
    std::mt19937_64 random(Catch::rngSeed());
    int most = 0;
    for (int i = 0; i < 2000; ++i) {
        const Pose pose = random_pose(random);
        const Forward again = forward(geometry, cable_lengths(geometry, pose));
        most = std::max(most, again.steps);
        REQUIRE((again.pose.position - pose.position).norm() < 1e-12);
        REQUIRE(angle_between(again.pose.rotation, pose.rotation) < 1e-11);
        REQUIRE(again.mismatch_m < 1e-12);
        // Six cables are enough from nearby.
        const Forward six = forward(geometry, cable_lengths(geometry, pose), again.pose,
                                    {true, true, false, true, true, true, false, true});
        REQUIRE((six.pose.position - pose.position).norm() < 1e-10);
    }
    INFO("most steps of 2000 random poses: " << most);
    CHECK(most <= 5);
    PerCable broken = cable_lengths(geometry, posed);
    broken[3] = 0.0;
    REQUIRE_REFUSED(forward(geometry, broken));
    REQUIRE_REFUSED(forward(geometry, cable_lengths(geometry, posed), {}, {true, true, true, true, true}));
}

TEST_CASE("robot: the structure is the derivative of the lengths, and its statics are virtual work", "[robot]") {
    const Geometry geometry = find_geometry();
    const Structure structure = structure_of(geometry, posed);
    constexpr double h = 1e-6;
    for (int k = 0; k < 6; ++k) {
        Pose more = posed, less = posed;
        if (k < 3) {
            more.position[k] += h;
            less.position[k] -= h;
        } else {
            more.rotation = rotation_of(h * Vector3::Unit(k - 3)) * posed.rotation;
            less.rotation = rotation_of(-h * Vector3::Unit(k - 3)) * posed.rotation;
        }
        const PerCable slope = (cable_lengths(geometry, more) - cable_lengths(geometry, less)) / (2 * h);
        REQUIRE((slope + structure.row(k).transpose()).norm() < 1e-8);  // a pull shortens its cable
    }
}

TEST_CASE("robot: how far encoder counts spread the pose", "[robot]") {
    const Geometry geometry = crossing();
    const double sd = 7.14e-6 / std::sqrt(12.0);
    const Wrench spread = pose_deviation(geometry, posed, sd);
    const double expected[] = {1.5, 1.4, 1.1, 1.5, 1.6, 2.0};
    for (int k = 0; k < 3; ++k) REQUIRE(spread[k] * 1e6 == Approx(expected[k]).margin(0.05));
    for (int k = 3; k < 6; ++k) REQUIRE(spread[k] / degree * 1e3 == Approx(expected[k]).margin(0.05));
    // The same from poses found for rounded lengths.
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> error(-7.14e-6 / 2, 7.14e-6 / 2);
    Wrench squares = Wrench::Zero();
    constexpr int runs = 4000;
    for (int i = 0; i < runs; ++i) {
        PerCable lengths = cable_lengths(geometry, posed);
        for (int k = 0; k < 8; ++k) lengths[k] += error(random);
        const Pose found = forward(geometry, lengths, posed).pose;
        Wrench off;
        off << found.position - posed.position, vector_of(found.rotation * posed.rotation.transpose());
        squares += off.cwiseAbs2();
    }
    for (int k = 0; k < 6; ++k) REQUIRE(std::sqrt(squares[k] / runs) == Approx(spread[k]).epsilon(0.06));
}

TEST_CASE("robot: tensions of least norm to the printed digits", "[robot]") {
    const Geometry geometry = crossing();
    const auto solve = [&](const Pose& pose, double down_n) {
        Wrench wrench = Wrench::Zero();
        wrench[2] = -0.1 * 9.81 - down_n;  // the printed numbers were computed with 9.81 m/s²
        const Structure structure = structure_of(geometry, pose);
        const auto found = distribute(structure, wrench, 0.5, 10);
        REQUIRE(found);
        REQUIRE((structure * found->tensions + wrench).norm() < 1e-12);
        return found->tensions;
    };
    // Odd corners are the upper ones.
    require_close(solve({}, 0), {0.5, 0.8671, 0.5, 0.8671, 0.5, 0.8671, 0.5, 0.8671}, 0.00005);
    require_close(solve({}, 5), {0.5, 2.7379, 0.5, 2.7379, 0.5, 2.7379, 0.5, 2.7379}, 0.00005);
    require_close(solve(posed, 0), {0.5, 1.2789, 0.5, 0.8962, 0.5259, 1.1998, 0.9466, 1.0771}, 0.00005);
}

TEST_CASE("robot: choices of tensions beside an exhaustive search of the null space", "[robot]") {
    const Geometry geometry = find_geometry();
    std::mt19937_64 random(Catch::rngSeed());
    std::normal_distribution<double> normal;
    int feasible = 0, refused = 0;
    for (int run = 0; run < 30; ++run) {
        const Pose pose = random_pose(random);
        const Structure structure = structure_of(geometry, pose);
        Wrench wrench = geometry.weight();
        for (int k = 0; k < 3; ++k) wrench[k] += 5 * normal(random);
        for (int k = 3; k < 6; ++k) wrench[k] += 0.1 * normal(random);
        // Another way to the same space: the SVD.
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(structure, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const PerCable particular = svd.solve(-wrench);
        const Eigen::MatrixXd null = svd.matrixV().rightCols(2);
        constexpr int steps = 250;
        constexpr double reach = 30.0;
        double norm = 1e9, sum = 1e9;
        long hits = 0;
        Eigen::Vector2d mean = Eigen::Vector2d::Zero();
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; j <= steps; ++j) {
                const Eigen::Vector2d y(reach * (2.0 * i / steps - 1), reach * (2.0 * j / steps - 1));
                const PerCable t = particular + null * y;
                if (t.minCoeff() < 0.5 || t.maxCoeff() > 10) continue;
                ++hits;
                mean += y;
                norm = std::min(norm, t.norm());
                sum = std::min(sum, t.sum());
            }
        const auto least = distribute(structure, wrench, 0.5, 10, Choice::least_norm);
        if (hits < 30) {  // too small for the search, or empty
            if (!least) ++refused;
            continue;
        }
        ++feasible;
        REQUIRE(least);
        const auto cheap = distribute(structure, wrench, 0.5, 10, Choice::least_sum);
        const auto middle = distribute(structure, wrench, 0.5, 10, Choice::centroid);
        for (const auto& found : {least, cheap, middle}) {
            REQUIRE((structure * found->tensions + wrench).norm() < 1e-12);
            REQUIRE(found->tensions.minCoeff() >= 0.5 - 1e-11);
            REQUIRE(found->tensions.maxCoeff() <= 10 + 1e-11);
        }
        REQUIRE(least->tensions.norm() <= norm + 1e-9);
        REQUIRE(least->tensions.norm() >= norm - 0.8);  // the search takes steps
        REQUIRE(cheap->tensions.sum() <= sum + 1e-9);
        REQUIRE(cheap->tensions.sum() >= sum - 2.0);
        const PerCable searched = particular + null * (mean / static_cast<double>(hits));
        REQUIRE((middle->tensions - searched).norm() < 0.8);
        // The paper's: the same wrench, the least tension is the limit, and the direction is positive everywhere.
        const auto paper = distribute(structure, wrench, 0.5, 10, Choice::paper);
        REQUIRE(paper);
        REQUIRE((structure * paper->tensions + wrench).norm() < 1e-11);
        REQUIRE(paper->tensions.minCoeff() == Approx(0.5));
        REQUIRE(paper->within_limits == (paper->tensions.maxCoeff() <= 10));
        const PerCable positive = *positive_null_vector(*tension_space(structure, wrench));
        double best = 0.0;
        for (int i = 0; i < 4000; ++i) {
            const double phi = 2 * std::numbers::pi * i / 4000;
            best = std::max(best, (null * Eigen::Vector2d(std::cos(phi), std::sin(phi))).minCoeff());
        }
        REQUIRE(positive.norm() == Approx(1.0));
        REQUIRE(positive.minCoeff() == Approx(best).margin(1e-3));
    }
    INFO(feasible << " feasible, " << refused << " refused");
    REQUIRE(feasible >= 3);
}

TEST_CASE("robot: the paper's tensions break the upper limit where the polygon's keep it", "[robot]") {
    const Geometry geometry = find_geometry();
    std::mt19937_64 random(Catch::rngSeed());
    std::uniform_real_distribution<double> force(-15, 15);
    int broken = 0;
    for (int i = 0; i < 2000; ++i) {
        const Structure structure = structure_of(geometry, random_pose(random));
        Wrench wrench = geometry.weight();
        for (int k = 0; k < 3; ++k) wrench[k] += force(random);
        const auto paper = distribute(structure, wrench, 0.5, 10, Choice::paper);
        const auto ours = distribute(structure, wrench, 0.5, 10);
        if (paper && !paper->within_limits && ours) ++broken;
        if (paper && paper->within_limits) REQUIRE(ours);
    }
    REQUIRE(broken > 0);
}

TEST_CASE("robot: a singular robot is told from a weak one", "[robot]") {
    Geometry geometry = find_geometry();
    // Straight connections: at the centre every cable's line goes through one point, so no torque can be made.
    for (std::size_t i = 0; i < 8; ++i) geometry.attachments[i] = geometry.anchors[i] / 9.0;
    REQUIRE_FALSE(tension_space(structure_of(geometry, {}), geometry.weight()));
    REQUIRE_FALSE(distribute(structure_of(geometry, {}), geometry.weight(), 0.5, 10));
    REQUIRE_SAID(infeasible(geometry, {}, geometry.weight()));
    REQUIRE(infeasible(find_geometry(), {}, geometry.weight()).empty());
}

TEST_CASE("robot: the largest forces of a user at the centre", "[robot]") {
    const Geometry geometry = crossing();
    const auto largest = [&](int axis, double sign) {
        Wrench direction = Wrench::Zero();
        direction[axis] = sign;
        return largest_wrench(geometry, {}, direction).value();
    };
    REQUIRE(largest(2, 1) == Approx(26.37).margin(0.005));
    REQUIRE(largest(2, -1) == Approx(24.41).margin(0.005));
    for (const int axis : {0, 1})
        for (const double sign : {1.0, -1.0}) REQUIRE(largest(axis, sign) == Approx(14.82).margin(0.005));
    // Up against down differ by twice the handle's weight.
    REQUIRE(largest(2, 1) - largest(2, -1) == Approx(2 * 0.1 * gravity_m_s2));
}

TEST_CASE("robot: cables that meet are told, beside a search along both", "[robot]") {
    const Geometry bad = crossing();
    const Clearance met = clearance(bad, {});
    CHECK(met.cables.distance_m < 1e-9);
    CHECK(met.cables.room_m == Approx(-0.001));
    CHECK_SAID(interference(bad, {}));
    CHECK_SAID(infeasible(bad, {}, bad.weight()));
    CHECK(workspace(bad, 0.030, Turns::none, 0).count == 0);
    CHECK(workspace(find_geometry(), 0.030, Turns::none, 0).count > 0);

    std::mt19937_64 random(Catch::rngSeed());
    for (int run = 0; run < 12; ++run) {
        const Geometry geometry = run % 2 == 0 ? find_geometry() : bad;
        const Pose pose = run < 2 ? Pose{} : random_pose(random);
        const auto end = [&](std::size_t i) {
            return Vector3(pose.position + pose.rotation * geometry.attachments[i]);
        };
        const Vector3 half = pose.rotation * Vector3(0, 0, (geometry.grip_length_m - geometry.grip_m) / 2);
        double cables = 1e9, grip = 1e9;
        for (std::size_t i = 0; i < 8; ++i) {
            grip = std::min(grip, sampled(geometry.anchors[i], end(i), pose.position - half, pose.position + half));
            for (std::size_t j = 0; j < i; ++j)
                cables = std::min(cables, sampled(geometry.anchors[i], end(i), geometry.anchors[j], end(j)));
        }
        const Clearance found = clearance(geometry, pose);
        CAPTURE(run, found.cables.words(), found.grip.words());
        CHECK(found.cables.distance_m == Approx(cables).margin(2e-6));
        CHECK(found.grip.distance_m == Approx(grip - geometry.grip_m / 2).margin(2e-6));
        CHECK(interference(geometry, pose).empty() == (cables >= 0.001 && grip >= geometry.grip_m / 2 + 0.0005));
    }
}

TEST_CASE("robot: of all ways to connect the corners, the default's workspace is nearest to the printed one",
          "[robot]") {
    constexpr double printed = 7.518e6;
    const Geometry shipped = find_geometry();
    const auto volume = [](const Geometry& geometry) {
        return workspace(geometry, 0.030, Turns::one_axis, 15 * degree).volume_m3() * 1e9;
    };
    const double ours = volume(shipped);
    CHECK(ours == Approx(7.533e6).margin(0.0005e6));
    const std::vector<Matrix3> turned = rotations(Turns::one_axis, 15 * degree);
    std::array<std::size_t, 8> order;
    std::iota(order.begin(), order.end(), 0);
    std::array<Vector3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] =
            shipped.anchors[i].cwiseQuotient(shipped.frame).cwiseProduct(2 * shipped.attachments[0].cwiseAbs());
    int hold = 0, as_near = 0;
    do {
        Geometry other = shipped;
        for (std::size_t i = 0; i < 8; ++i) other.attachments[i] = corners[order[i]];
        const bool holds = std::all_of(turned.begin(), turned.end(), [&](const Matrix3& rotation) {
            return infeasible(other, {Vector3::Zero(), rotation}, other.weight()).empty();
        });
        if (!holds) continue;
        ++hold;
        if (std::abs(volume(other) - printed) <= std::abs(ours - printed)) ++as_near;
    } while (std::next_permutation(order.begin(), order.end()));
    INFO(hold << " of 40320 hold the handle at the centre");
    CHECK(hold > 100);
    CHECK(as_near == 4);  // the default, and the three that are its mirror images
}

TEST_CASE("robot: of all near sizes that reach as far, none's workspace is nearer to the printed one", "[robot]") {
    const Geometry shipped = find_geometry();
    // Every 10 mm of the frame, 2 mm of the handle's width and 4 mm of its height; 172 mm is where 10 N carry the
    // handle.
    const auto off = [&](int edge_mm, int width_mm, int height_mm) {
        Geometry sized = with_edge(shipped, edge_mm * 1e-3);
        for (Vector3& end : sized.attachments)
            end = end.cwiseSign().cwiseProduct(Vector3(width_mm, width_mm, height_mm) * 0.5e-3);
        sized.grip_length_m = height_mm * 1e-3;
        for (const double height : {0.172, -0.172})
            if (!infeasible(sized, {{0, 0, height}, Matrix3::Identity()}, sized.weight()).empty()) return 1e9;
        return std::abs(workspace(sized, 0.030, Turns::one_axis, 15 * degree).volume_m3() * 1e9 - 7.518e6);
    };
    const double ours = off(390, 38, 60);
    CHECK(ours == Approx(0.015e6).margin(0.0005e6));
    for (int edge = 360; edge <= 420; edge += 10)
        for (int width = 34; width <= 42; width += 2)
            for (int height = 52; height <= 68; height += 4) {
                CAPTURE(edge, width, height);
                CHECK(off(edge, width, height) >= ours);
            }
}

TEST_CASE("robot: useful workspaces", "[robot]") {
    const Geometry geometry = find_geometry();
    const auto volume = [&](double edge, Turns turns) {
        return workspace(with_edge(geometry, edge), 0.030, turns, 15 * degree).volume_m3() * 1e9;
    };
    // The printed volume is 7.518·10⁶ mm³; one cube of the grid is 0.4 % of it.
    CHECK(volume(0.39, Turns::one_axis) == Approx(7.533e6).margin(0.0005e6));
    CHECK(volume(0.39, Turns::all_axes) == Approx(4.428e6).margin(0.0005e6));
    // The zones of task T1 end at 160 mm.
    for (const double height : {0.160, -0.160})
        CHECK(infeasible(geometry, {{0, 0, height}, Matrix3::Identity()}, geometry.weight()).empty());
    CHECK(clearance(geometry, {}).cables.distance_m * 1e3 == Approx(28.4).margin(0.05));
    CHECK(clearance(geometry, {}).cables.words().find("cables 1 and 6 ") == 0);
    CHECK(clearance(geometry, {}).grip.distance_m * 1e3 == Approx(13.55).margin(0.05));
    const Workspace all = workspace(geometry, 0.030, Turns::all_axes, 15 * degree);
    REQUIRE(all.useful.size() == 13 * 13 * 13);
    REQUIRE(static_cast<std::size_t>(std::count(all.useful.begin(), all.useful.end(), true)) == all.count);
    REQUIRE(all.useful[13 * 13 * 6 + 13 * 6 + 6]);  // the centre
    REQUIRE(all.axis[0].front() == Approx(-0.180));
    REQUIRE(all.axis[0].back() == Approx(0.180));
    REQUIRE(rotations(Turns::all_axes, 0.1).size() == 27);
    REQUIRE(rotations(Turns::one_axis, 0.1).size() == 7);
    // The zones' balls: the outer one is larger than the workspace.
    constexpr double ball = 4.0 / 3.0 * std::numbers::pi;
    REQUIRE(ball * 120 * 120 * 120 == Approx(7.238e6).margin(0.0005e6));
    REQUIRE(ball * 160 * 160 * 160 == Approx(1.716e7).margin(0.0005e7));
    Workspace printed;
    printed.step_m = 1e-3;
    printed.count = 7518000;
    REQUIRE(printed.ball_radius_m() * 1e3 == Approx(121.5).margin(0.05));
    REQUIRE_REFUSED(workspace(geometry, 0.0, Turns::none, 0));
    REQUIRE_REFUSED(workspace(geometry, 1e-5, Turns::none, 0));
    REQUIRE_REFUSED(workspace(geometry, 0.03, Turns::all_axes, 2));
}

#ifndef __SANITIZE_ADDRESS__  // which makes everything slower
TEST_CASE("robot: tensions take 20 µs at most, a workspace of 27 turns a second", "[robot][real-time]") {
    // The best of several runs, because other programs may be running.
    const auto best_s = [](int runs, const std::function<void()>& work) {
        double best = 1e9;
        for (int i = 0; i < runs; ++i) {
            const test::StopWatch watch;
            work();
            best = std::min(best, watch.seconds());
        }
        return best;
    };
    const Geometry geometry = find_geometry();
    const Structure structure = structure_of(geometry, posed);
    for (const Choice choice : {Choice::least_norm, Choice::least_sum, Choice::centroid, Choice::paper}) {
        constexpr int batch = 500;
        double sum = 0.0;
        const double one = best_s(10,
                                  [&] {
                                      for (int i = 0; i < batch; ++i) {
                                          Wrench wrench = geometry.weight();
                                          wrench[0] = 0.01 * i;
                                          sum += distribute(structure, wrench, 0.5, 10, choice)->tensions[0];
                                      }
                                  }) /
                           batch;
        test::compare(fmt::format("tensions of eight cables, choice {}", static_cast<int>(choice)), one * 1e6, 20.0,
                      "µs");
        REQUIRE(sum > 0.0);
    }
    const double whole = best_s(3, [&] { (void)workspace(geometry, 0.030, Turns::all_axes, 15 * degree); });
    test::compare("a workspace of 27 turns", whole, 1.0, "s");
}
#endif

TEST_CASE("robot: a file that cannot be used names its line", "[robot]") {
    const TemporaryFolder folder;
    const std::string good = read_file("shipped:robots/cube-390.toml");
    const std::string path = (folder.path() / "own.toml").string();
    const auto refused = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        const auto at = text.find(from);
        REQUIRE(at != std::string::npos);
        write_file(path, text.replace(at, from.size(), to));
        return heard::refusal_of([&] { (void)load_geometry(path); });
    };
    REQUIRE_REFUSAL(refused("[5, 2, 6", "[5, 5, 6"));
    REQUIRE_REFUSAL(refused("grip_mm = 30", "grip_mm = 54"));
    REQUIRE_REFUSAL(refused("cable_diameter_mm = 1", "cable_diameter_mm = 0"));
    REQUIRE_REFUSAL(refused("[0.5, 10]", "[10, 0.5]"));
    REQUIRE_REFUSAL(refused("[390, 390, 390]", "[390, -390, 390]"));
    REQUIRE_REFUSAL(refused("mass_kg", "mass"));
    REQUIRE_REFUSAL(refused("robot-1", "robot-9"));
    REQUIRE_REFUSED(find_geometry("none"));
    REQUIRE_REFUSED(with_edge(find_geometry(), 0));
}
