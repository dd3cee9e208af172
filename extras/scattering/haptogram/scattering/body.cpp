// SPDX-License-Identifier: Apache-2.0
#include "haptogram/scattering/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "haptogram/base/error.hpp"
#include "haptogram/hand/mesh_solid.hpp"
#include "haptogram/scattering/shells.hpp"

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

}  // namespace haptogram::scattering
