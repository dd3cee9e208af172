// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/round_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptogram/base/error.hpp"

namespace haptogram::scattering {
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
