// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "../refusal.hpp"
#include "haptogram/acoustics/propagation.hpp"
#include "haptogram/acoustics/quantities.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/process.hpp"
#include "haptogram/scattering/scatter.hpp"
#include "haptogram/scattering/scatterer.hpp"
#include "haptogram/scattering/shells.hpp"

using namespace haptogram;
using namespace haptogram::scattering;
using std::numbers::pi;

namespace {

ScatterSource ball_at(Vec3 centre) {
    ScatterSource source;
    source.body.name = "sphere";
    source.body.radius_m = 5e-3;
    source.body.placement.center = centre;
    source.foci = {centre - Vec3{0.0, 0.0, 5e-3}};
    return source;
}

heard::Refusal refusal(const ScatterSource& source) {
    return heard::refusal_of([&] { (void)scatter(source); });
}

}  // namespace

TEST_CASE("scattering: shells that do not bound one body are refused", "[scattering]") {
    const auto moved = [](Mesh mesh, Vec3 by) {
        for (Vec3& vertex : mesh.vertices) vertex = vertex + by;
        return mesh;
    };
    const auto turned = [](Mesh mesh) {
        for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
        return mesh;
    };
    const auto both = [](Mesh one, const Mesh& other) {
        const auto before = static_cast<std::uint32_t>(one.vertices.size());
        one.vertices.insert(one.vertices.end(), other.vertices.begin(), other.vertices.end());
        for (const auto& [a, b, c] : other.triangles) one.triangles.push_back({a + before, b + before, c + before});
        return one;
    };
    const Mesh large = sphere_mesh(8e-3, 2e-3), small = sphere_mesh(3e-3, 1e-3);
    const double sum = body_of(large, "a").volume + body_of(small, "b").volume;
    CHECK(body_of(both(large, moved(small, from_mm(12, 0, 0))), "apart").volume == Approx(sum));
    CHECK(body_of(both(large, turned(moved(small, from_mm(1, 1, 1)))), "hollow").volume < sum);
    const auto refused = [](const Mesh& mesh) { return heard::refusal_of([&] { (void)body_of(mesh, "two.ply"); }); };
    CHECK_REFUSAL(refused(both(large, moved(small, from_mm(8, 0, 0)))));
    CHECK_REFUSAL(refused(both(large, small)));
    CHECK_REFUSAL(refused(both(large, turned(moved(small, from_mm(12, 0, 0))))));
    // Two bars as a cross: no corner of one lies in the other, only edges meet faces.
    const auto bar = [](double x, double y, double z) {
        Mesh box;
        for (int i = 0; i < 8; ++i) box.vertices.push_back({(i & 1 ? x : -x), (i & 2 ? y : -y), (i & 4 ? z : -z)});
        box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                         {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
        return box;
    };
    CHECK(body_of(bar(9e-3, 1e-3, 1e-3), "bar").volume == Approx(8 * 9e-9));
    CHECK_REFUSAL(refused(both(bar(9e-3, 1e-3, 1e-3), bar(2e-3, 9e-3, 0.5e-3))));
}

TEST_CASE("scattering: built-in bodies have their volume, even triangles and outward normals", "[scattering]") {
    const double edge = GENERATE(0.6e-3, 1.1e-3, 2e-3);
    const Body ball = body_of(sphere_mesh(8e-3, edge), "sphere");
    REQUIRE(ball.volume == Approx(4.0 / 3.0 * pi * 512e-9).epsilon(1e-6));
    REQUIRE(ball.area == Approx(4.0 * pi * 64e-6).epsilon(0.02));
    const Body finger = body_of(capsule_mesh(8e-3, 50e-3, edge), "finger");
    REQUIRE(finger.volume == Approx(pi * 64e-6 * (34e-3 + 4.0 / 3.0 * 8e-3)).epsilon(1e-6));
    REQUIRE(finger.area == Approx(2.0 * pi * 8e-3 * 50e-3).epsilon(0.02));
    for (const Body* body : {&ball, &finger}) {
        REQUIRE(body->mean_edge() == Approx(edge).epsilon(0.05));
        REQUIRE(body->longest_edge() < 1.6 * edge);
        double least = 1.0;
        for (const Panel& panel : body->panels) {
            const Vec3 middle{0.0, 0.0,
                              std::clamp(panel.centre.z, body == &ball ? 0.0 : -17e-3, body == &ball ? 0.0 : 17e-3)};
            const Vec3 out = panel.centre - middle;
            REQUIRE(dot(out, panel.normal) > 0.9 * norm(out));
            least = std::min(least, panel.area / (std::sqrt(3.0) / 4.0 * panel.longest_edge * panel.longest_edge));
        }
        REQUIRE(least > 0.4);  // 1 is equilateral
    }
    // The finger of the paper Fingers: 4322 triangles on 5 cm.
    REQUIRE(body_of(capsule_mesh(8e-3, 50e-3, 1.16e-3), "finger").panels.size() == Approx(4322).epsilon(0.01));
}

TEST_CASE("scattering: bodies that cannot be computed are refused with what would help", "[scattering]") {
    Mesh open = sphere_mesh(8e-3, 2e-3);
    open.triangles.pop_back();
    REQUIRE_REFUSED(body_of(open, "open.ply"));
    Mesh inside_out = sphere_mesh(8e-3, 2e-3);
    for (auto& t : inside_out.triangles) std::swap(t[1], t[2]);
    REQUIRE_REFUSED(body_of(inside_out, "in.stl"));
    REQUIRE_REFUSED(sphere_mesh(8e-3, 9e-3));
    REQUIRE_REFUSED(capsule_mesh(8e-3, 15e-3, 1e-3));
    const Body coarse = body_of(sphere_mesh(8e-3, 2e-3), "coarse");
    REQUIRE_REFUSED(require_fine(coarse, 8.58e-3, 6.0));
    Mesh spike = sphere_mesh(8e-3, 1e-3);
    spike.vertices.front().z -= 6e-3;
    const Body spiked = body_of(spike, "spike");
    REQUIRE_REFUSED(require_fine(spiked, 8.58e-3, 6.0));
}

TEST_CASE("scattering: what an array sends to a body is its field and its slope there", "[scattering]") {
    const Array array = find_array("tile-10x10");
    const Shape placed = placed_at(Shape{{sphere_mesh(8e-3, 2e-3)}}, {.center = Vec3{0.01, 0.0, 0.12}});
    const Body body = body_of(std::get<Mesh>(placed.pieces.front()), "ball");
    const auto drives = ideal_drives(array, from_mm(5, 0, 110));
    const IncidentSound sound = incident_from(array, drives, body);
    double most = 0.0;
    for (const Panel& panel : body.panels) most = std::max(most, std::abs(pressure(array, drives, panel.centre)));
    const double k = 2.0 * pi / array.wavelength_m();
    for (std::size_t i = 0; i < body.panels.size(); i += 17) {
        const Panel& panel = body.panels[i];
        const ComplexVec3 gradient = pressure_gradient(array, drives, panel.centre);
        const auto slope = gradient.x * panel.normal.x + gradient.y * panel.normal.y + gradient.z * panel.normal.z;
        REQUIRE(std::abs(std::complex<double>(sound.pressure[i]) - pressure(array, drives, panel.centre)) <
                1e-3 * most);
        REQUIRE(std::abs(std::complex<double>(sound.slope[i]) - slope) < 1e-3 * k * most);
    }
}

TEST_CASE("scatter: a ball before a tile is pushed away, most where the focus is", "[scattering]") {
    ScatterSource source = ball_at(from_mm(0, 0, 120));
    source.flat_estimate = true;
    const Scattered found = scatter(source);
    REQUIRE(found.force_n.z > 0.0);
    REQUIRE(std::abs(found.force_n.x) < 0.01 * found.force_n.z);
    REQUIRE(std::abs(found.force_n.y) < 0.01 * found.force_n.z);
    const Vec3 highest = found.body.panels[found.highest].centre;
    REQUIRE(distance(highest, source.foci.front()) < 1.5e-3);
    // At the skin that faces the array, a focus is little wider than the ball: less than on a wall, where it is α = 2.
    const auto drives = ideal_drives(found.array, source.foci.front());
    const double wall =
        radiation_pressure(pressure(found.array, drives, source.foci.front()), found.array.medium, total_reflection);
    REQUIRE(found.radiation[found.highest] < wall);
    REQUIRE(found.radiation[found.highest] > 0.5 * wall);
    // The estimate by flat skin is that wall, less what comes in obliquely.
    REQUIRE(found.flat[found.highest] < 1.01 * wall);
    REQUIRE(found.flat[found.highest] > 0.9 * wall);
}

TEST_CASE("scatter: several foci in turn are the mean, a path weighs by time and modulation", "[scattering]") {
    const Vec3 centre = from_mm(0, 0, 120), one = centre - Vec3{3e-3, 0.0, 5e-3},
               other = centre + Vec3{3e-3, 0.0, -5e-3};
    ScatterSource source = ball_at(centre);
    source.foci = {one};
    const Scattered first = scatter(source);
    source.foci = {other};
    const Scattered second = scatter(source);
    source.foci = {one, other};
    const Scattered both = scatter(source);
    REQUIRE(both.steps.size() == 2);
    const TemporaryFolder folder;
    source.foci.clear();
    source.path = (folder.path() / "path.csv").string();
    // A quarter of the time at each, and half of it silence; the second with half the amplitude.
    write_file(source.path,
               "time_ms,x_mm,y_mm,z_mm,intensity\n0,-3,0,115,1\n1,3,0,115,0.5\n2,0,0,115,0\n3,0,0,115,0\n");
    const Scattered timed = scatter(source);
    REQUIRE(timed.resting == Approx(0.5));
    for (std::size_t i = 0; i < both.radiation.size(); i += 7) {
        const auto a = static_cast<double>(first.radiation[i]), b = static_cast<double>(second.radiation[i]);
        const double tolerance = 2e-3 * static_cast<double>(first.radiation[first.highest]);
        REQUIRE(static_cast<double>(both.radiation[i]) == Approx((a + b) / 2.0).margin(tolerance));
        REQUIRE(static_cast<double>(timed.radiation[i]) == Approx(a / 4.0 + b / 16.0).margin(tolerance));
    }
}

TEST_CASE("scatter: what makes no sense is refused", "[scattering]") {
    const Vec3 centre = from_mm(0, 0, 120);
    ScatterSource source = ball_at(centre);
    source.foci = {centre};
    REQUIRE_REFUSAL(refusal(source));
    source.foci_inside = true;
    REQUIRE(refusal(source).identity == "no error");
    source = ball_at(from_mm(0, 0, 4));
    source.body.radius_m = 8e-3;
    REQUIRE_REFUSAL(refusal(source));
    source = ball_at(centre);
    source.body.edge_m = 3e-3;
    REQUIRE_REFUSAL(refusal(source));
    source = ball_at(centre);
    source.body.length_m = 20e-3;
    REQUIRE_REFUSAL(refusal(source));
    source = ball_at(centre);
    source.foci.clear();
    REQUIRE_REFUSAL(refusal(source));
    source = ball_at(centre);
    source.body.name = "missing.ply";
    source.body.radius_m.reset();
    REQUIRE_REFUSAL(refusal(source));
}
