// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/shells.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/mesh_solid.hpp"

namespace haptogram::scattering {
namespace {

/// One shell, and the solid inside it whichever way its faces look.
struct Shell {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    Solid solid;
    bool inwards = false;
    std::size_t around = 0;  ///< how many others it lies in
};

double volume_of(const Mesh& mesh, const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    const std::vector<Vec3>& v = mesh.vertices;
    const Vec3 origin = v[triangles.front()[0]];
    double volume = 0.0;
    for (const auto& [a, b, c] : triangles) volume += dot(v[a] - origin, cross(v[b] - origin, v[c] - origin)) / 6.0;
    return volume;
}

std::vector<Shell> shells_of(const Mesh& mesh) {
    std::vector<std::uint32_t> owner(mesh.vertices.size());
    std::iota(owner.begin(), owner.end(), 0U);
    const auto root = [&](std::uint32_t i) {
        while (owner[i] != i) i = owner[i] = owner[owner[i]];
        return i;
    };
    for (const auto& [a, b, c] : mesh.triangles) owner[root(a)] = owner[root(b)] = root(c);
    std::map<std::uint32_t, Shell> found;
    for (const auto& triangle : mesh.triangles) found[root(triangle[0])].triangles.push_back(triangle);
    std::vector<Shell> shells;
    for (auto& [_, shell] : found) shells.push_back(std::move(shell));
    if (shells.size() == 1) return shells;  // nothing to compare it with
    for (Shell& shell : shells) {
        shell.inwards = volume_of(mesh, shell.triangles) < 0.0;
        std::vector<std::array<std::uint32_t, 3>> outwards = shell.triangles;
        if (shell.inwards)
            for (auto& triangle : outwards) std::swap(triangle[1], triangle[2]);
        shell.solid = mesh_solid(mesh.vertices, outwards);
    }
    return shells;
}

/// Whether the way from a to b meets a solid's surface. No distance changes faster than the way does, so a stretch that
/// is shorter than the distances at its ends together is clear.
bool meets(const Solid& solid, Vec3 a, double at_a, Vec3 b, double at_b) {
    constexpr double touching_m = 1e-9;
    if ((at_a < 0.0) != (at_b < 0.0)) return true;
    const double way = distance(a, b);
    if (std::abs(at_a) + std::abs(at_b) > way) return false;
    if (way < touching_m) return true;
    const Vec3 middle = (a + b) * 0.5;
    const double at_middle = solid.distance(middle);
    return meets(solid, a, at_a, middle, at_middle) || meets(solid, middle, at_middle, b, at_b);
}

std::string in_mm(Vec3 p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g}) mm", p.x / millimetre, p.y / millimetre, p.z / millimetre);
}

/// @throws Error{bad_input} when an edge of one shell meets the other
void require_apart(const Mesh& mesh, const Shell& shell, const Shell& other) {
    const std::vector<Vec3>& v = mesh.vertices;
    for (const auto& triangle : shell.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t from = triangle.at(i), to = triangle.at((i + 1) % 3);
            if (from > to) continue;  // the other triangle of this edge has it the other way round
            if (meets(other.solid, v[from], other.solid.distance(v[from]), v[to], other.solid.distance(v[to])))
                throw bad_input("mesh", fmt::format("two parts of it run through each other or touch near {}; unite "
                                                    "them into one surface, or move them apart",
                                                    in_mm((v[from] + v[to]) * 0.5)));
        }
}

}  // namespace

void require_one_body(const Mesh& mesh) {
    std::vector<Shell> shells = shells_of(mesh);
    if (shells.size() == 1) return;
    for (Shell& shell : shells)
        for (const Shell& other : shells) {
            if (&shell == &other) continue;
            require_apart(mesh, shell, other);
            shell.around += other.solid.distance(mesh.vertices[shell.triangles.front()[0]]) < 0.0 ? 1 : 0;
        }
    for (const Shell& shell : shells)
        if (shell.inwards != (shell.around % 2 == 1))
            throw bad_input("mesh",
                            fmt::format("its part at {} lies in {} others, but faces {}; turn the order of its "
                                        "triangles' corners round, or leave it out",
                                        in_mm(mesh.vertices[shell.triangles.front()[0]]), shell.around,
                                        shell.inwards ? "inwards, as the wall of a hollow" : "outwards, as a body"));
}

}  // namespace haptogram::scattering
