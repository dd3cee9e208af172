// SPDX-License-Identifier: Apache-2.0
// Measures the cable robot for tools/bench.py, on one thread; prints one JSON object. Times are the least of several
// runs, as other programs only add to them.
#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "haptogram/robot/geometry.hpp"
#include "haptogram/robot/tension.hpp"
#include "haptogram/robot/workspace.hpp"
#include "least.hpp"

namespace {

using namespace haptogram::robot;
using haptogram::bench::least_s;
constexpr double degree = std::numbers::pi / 180.0;

}  // namespace

int main() {
    const Geometry geometry = find_geometry();
    nlohmann::ordered_json measured;
    const Structure structure =
        structure_of(geometry, {Vector3(0.020, -0.010, 0.030), rotation_xyz(Vector3(5, -3, 10) * degree)});
    for (const auto& [name, choice] : {std::pair("norm", Choice::least_norm), std::pair("sum", Choice::least_sum),
                                       std::pair("centroid", Choice::centroid), std::pair("paper", Choice::paper)}) {
        constexpr int batch = 1000;
        double sum = 0.0;
        const double seconds = least_s(10, [&] {
            for (int i = 0; i < batch; ++i) {
                Wrench wrench = geometry.weight();
                wrench[0] = 0.005 * i;
                sum += distribute(structure, wrench, geometry.least_n, geometry.most_n, choice).value().tensions[0];
            }
        });
        if (!(sum > 0.0)) return 1;  // so that no compiler leaves the work out
        measured[fmt::format("tension_{}_us", name)] = seconds / batch * 1e6;
    }
    // Forward kinematics from the centre, over poses of the useful workspace.
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> place(-0.06, 0.06), turn(-15 * degree, 15 * degree);
    int most_steps = 0;
    double worst_m = 0.0, worst_rad = 0.0;
    constexpr int poses = 20000;
    for (int i = 0; i < poses; ++i) {
        const Pose pose{Vector3(place(random), place(random), place(random)),
                        rotation_xyz({turn(random), turn(random), turn(random)})};
        const Forward found = forward(geometry, cable_lengths(geometry, pose));
        most_steps = std::max(most_steps, found.steps);
        worst_m = std::max(worst_m, (found.pose.position - pose.position).norm());
        worst_rad = std::max(worst_rad, vector_of(found.pose.rotation * pose.rotation.transpose()).norm());
    }
    measured["forward_poses"] = poses;
    measured["forward_steps"] = most_steps;
    measured["forward_error_m"] = worst_m;
    measured["forward_error_rad"] = worst_rad;
    std::size_t count = 0;
    measured["workspace_s"] =
        least_s(3, [&] { count = workspace(geometry, 0.030, Turns::all_axes, 15 * degree).count; });
    measured["workspace_cubes"] = count;
    fmt::print("{}\n", measured.dump());
    return 0;
}
