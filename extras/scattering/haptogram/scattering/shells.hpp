// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "haptogram/hand/solid.hpp"
#include "haptogram/shape/shape.hpp"

namespace haptogram::scattering {

/// One boundary element: a flat triangle, on which the pressure is that at its centre.
struct Panel {
    Vec3 centre, normal;  ///< the normal has length 1 and points out of the body
    double area = 0.0;
    double longest_edge = 0.0;
};

/// A rigid body in the sound field: a closed surface, and its panels, one a triangle and in the same order.
struct Body {
    std::string name;
    Mesh mesh;  ///< without repeated vertices or triangles that are lines
    std::vector<Panel> panels;
    Solid solid;  ///< the same body as a signed distance
    double area = 0.0, volume = 0.0;

    /// Of an equilateral triangle with the mean area of the panels, metres.
    [[nodiscard]] double mean_edge() const;
    [[nodiscard]] double longest_edge() const;
};

/// Makes a body of a surface.
/// @param name  for messages
/// @throws Error{bad_input} naming the body, as mesh_solid(): and require_one_body()
[[nodiscard]] Body body_of(Mesh mesh, const std::string& name);

/// Panels are fine enough when they have `least` elements a wavelength along their mean edge, and two thirds of that
/// along the longest.
/// @throws Error{bad_input} naming the panel and what edge would do
void require_fine(const Body& body, double wavelength_m, double least);

/// That the shells of a mesh, which are its connected parts, bound one body: none runs through another, and one inside
/// another faces the other way, as the wall of a hollow does. Otherwise some of the space would count twice.
/// @param mesh  closed, without repeated vertices
/// @throws Error{bad_input} naming "mesh", where it is, and what to do
void require_one_body(const Mesh& mesh);

// Meshes for boundary elements: triangles that are nearly equilateral. Their corners lie a little outside of the true
// surface, so that the mesh has the true volume: a scattered wave depends on it first.

/// @param edge  wanted length of the triangles' edges, metres
/// @throws Error{bad_argument} when a measure is not positive and finite, the edge is longer than the radius, or makes
///         more than a million triangles
[[nodiscard]] Mesh sphere_mesh(double radius, double edge);
/// A cylinder with half a sphere at each end, along z, centred on the origin: the tip of a finger.
/// @param length  of the whole, at least twice the radius
[[nodiscard]] Mesh capsule_mesh(double radius, double length, double edge);

}  // namespace haptogram::scattering
