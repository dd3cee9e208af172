// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/shells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/solid.hpp"

namespace haptogram::scattering {
namespace {

/// Without vertices that a file repeats, and triangles of which that leaves a line.
Mesh compact(const Mesh& mesh) {
    const std::vector<std::uint32_t> same = welded(mesh.vertices);
    Mesh made;
    std::vector<std::uint32_t> number(mesh.vertices.size());
    for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
        if (same[i] != i) continue;
        number[i] = static_cast<std::uint32_t>(made.vertices.size());
        made.vertices.push_back(mesh.vertices[i]);
    }
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::array<std::uint32_t, 3> t{number[same[a]], number[same[b]], number[same[c]]};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) made.triangles.push_back(t);
    }
    return made;
}

Panel panel_of(Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 across = cross(b - a, c - a);
    return {(a + b + c) * (1.0 / 3.0), across * (1.0 / norm(across)), norm(across) / 2.0,
            std::max({distance(a, b), distance(b, c), distance(c, a)})};
}

}  // namespace

double Body::mean_edge() const { return std::sqrt(4.0 / std::sqrt(3.0) * area / static_cast<double>(panels.size())); }

double Body::longest_edge() const {
    double longest = 0.0;
    for (const Panel& panel : panels) longest = std::max(longest, panel.longest_edge);
    return longest;
}

Body body_of(Mesh mesh, const std::string& name) {
    Body body{name, {}, {}, {}, 0.0, 0.0};
    try {
        body.solid = mesh_solid(mesh.vertices, mesh.triangles);
        body.mesh = compact(mesh);
        require_one_body(body.mesh);
    } catch (const Error& error) {
        throw bad_input(name, error.message());
    }
    for (const auto& [i, j, k] : body.mesh.triangles) {
        const auto& v = body.mesh.vertices;
        body.panels.push_back(panel_of(v[i], v[j], v[k]));
        const Panel& panel = body.panels.back();
        body.area += panel.area;
        body.volume += panel.area * dot(panel.centre - v[0], panel.normal) / 3.0;
    }
    return body;
}

void require_fine(const Body& body, double wavelength_m, double least) {
    const auto refuse = [&](const std::string& found) {
        return bad_input(body.name,
                         fmt::format("its triangles are too large for waves of {:.2f} mm: {}; {:g} a wavelength are "
                                     "asked for. Refine the mesh to edges of {:.2f} mm",
                                     wavelength_m / millimetre, found, least, wavelength_m / least / millimetre));
    };
    if (const double edge = body.mean_edge(); wavelength_m / edge < least)
        throw refuse(
            fmt::format("a mean edge of {:.2f} mm is {:.1f} a wavelength", edge / millimetre, wavelength_m / edge));
    const auto longest = std::max_element(body.panels.begin(), body.panels.end(), [](const Panel& a, const Panel& b) {
        return a.longest_edge < b.longest_edge;
    });
    if (1.5 * wavelength_m / longest->longest_edge < least)
        throw refuse(fmt::format("triangle {} at ({:.2f}, {:.2f}, {:.2f}) mm has an edge of {:.2f} mm",
                                 longest - body.panels.begin() + 1, longest->centre.x / millimetre,
                                 longest->centre.y / millimetre, longest->centre.z / millimetre,
                                 longest->longest_edge / millimetre));
}

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

namespace {

using std::numbers::pi;

/// Points on one height, at even angles.
struct Ring {
    double height, radius, first_angle;
    std::uint32_t first, count;  ///< vertices
    [[nodiscard]] double angle(std::uint32_t i) const { return first_angle + 2.0 * pi * i / count; }
};

Ring add_ring(Mesh& mesh, double height, double radius, double first_angle, std::uint32_t count) {
    const Ring ring{height, radius, first_angle, static_cast<std::uint32_t>(mesh.vertices.size()), count};
    for (std::uint32_t i = 0; i < count; ++i)
        mesh.vertices.push_back({radius * std::cos(ring.angle(i)), radius * std::sin(ring.angle(i)), height});
    return ring;
}

/// Triangles between two rings, always across the shorter step in angle. The lower one comes first.
void join(Mesh& mesh, const Ring& low, const Ring& high) {
    const auto of = [](const Ring& ring, std::uint32_t i) { return ring.first + i % ring.count; };
    std::uint32_t a = 0, b = 0;
    while (a < low.count || b < high.count) {
        const bool step_low =
            a < low.count && (b == high.count || low.angle(a + 1) + low.angle(a) <= high.angle(b + 1) + high.angle(b));
        if (step_low) {
            if (low.count > 1) mesh.triangles.push_back({of(low, a), of(low, a + 1), of(high, b)});
            ++a;
        } else {
            if (high.count > 1) mesh.triangles.push_back({of(low, a), of(high, b + 1), of(high, b)});
            ++b;
        }
    }
}

double volume_of(const Mesh& mesh) {
    double volume = 0.0;
    for (const auto& [a, b, c] : mesh.triangles)
        volume += dot(mesh.vertices[a], cross(mesh.vertices[b], mesh.vertices[c])) / 6.0;
    return volume;
}

/// The meridian goes from the lower pole to the upper one; `way` is its length from there.
Mesh revolve(double radius, double straight, double edge) {
    const double arc = pi / 2.0 * radius, whole = 2.0 * arc + straight;
    const auto rows = static_cast<std::uint32_t>(std::lround(whole / (edge * std::sqrt(3.0) / 2.0)));
    Mesh mesh;
    Ring last{};
    for (std::uint32_t row = 0; row <= rows; ++row) {
        const double way = whole * row / rows;
        const double up = std::min(way, arc), down = std::min(whole - way, arc);
        const double across = radius * std::sin(std::min(up, down) / radius);
        const double middle = std::clamp(way - arc, 0.0, straight);
        const double height =
            middle - straight / 2.0 - radius * std::cos(up / radius) + radius * std::cos(down / radius);
        const bool pole = row == 0 || row == rows;
        const auto count = pole ? 1U : std::max(5U, static_cast<std::uint32_t>(std::lround(2.0 * pi * across / edge)));
        const Ring ring = add_ring(mesh, height, pole ? 0.0 : across, pi / count * (row % 2), count);
        if (row > 0) join(mesh, last, ring);
        last = ring;
    }
    return mesh;
}

constexpr double most_triangles = 1e6;  // of a built-in body; fewer can be computed

void require(const char* name, double value, bool fits, const std::string& expected) {
    if (!std::isfinite(value) || !fits)
        throw bad_argument(name, fmt::format("must be {}, found {:g} mm", expected, value / millimetre));
}

}  // namespace

Mesh capsule_mesh(double radius, double length, double edge) {
    require("radius", radius, radius > 0.0, "positive");
    require("length", length, length >= 2.0 * radius,
            fmt::format("at least {:g} mm, twice the radius", 2.0 * radius / millimetre));
    require("edge", edge, edge > 0.0 && edge <= radius,
            fmt::format("positive, and at most {:g} mm, the radius", radius / millimetre));
    const double straight = length - 2.0 * radius;
    const double volume = pi * radius * radius * (4.0 / 3.0 * radius + straight);
    const double surface = 2.0 * pi * radius * (2.0 * radius + straight);
    const double least_edge = std::sqrt(surface / (std::sqrt(3.0) / 4.0 * most_triangles));
    require("edge", edge, edge >= least_edge,
            fmt::format("at least {:.3g} mm, which makes a million triangles", least_edge / millimetre));
    Mesh mesh;
    double outwards = 0.0;
    for (int round = 0; round < 4;
         ++round) {  // each makes the difference smaller by the edge's square over the radius's
        mesh = revolve(radius + outwards, straight, edge);
        outwards += (volume - volume_of(mesh)) / surface;
    }
    return mesh;
}

Mesh sphere_mesh(double radius, double edge) { return capsule_mesh(radius, 2.0 * radius, edge); }

}  // namespace haptogram::scattering
