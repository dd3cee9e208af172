// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/shape/shape.hpp"

namespace haptogram::scattering {

// Meshes for boundary elements: triangles that are nearly equilateral. Their corners lie a little outside of the true
// surface, so that the mesh has the true volume: a scattered wave depends on it first.

/// @param edge  wanted length of the triangles' edges, metres
/// @throws Error{bad_argument} when a measure is not positive and finite, or the edge is longer than the radius
[[nodiscard]] Mesh sphere_mesh(double radius, double edge);
/// A cylinder with half a sphere at each end, along z, centred on the origin: the tip of a finger.
/// @param length  of the whole, at least twice the radius
[[nodiscard]] Mesh capsule_mesh(double radius, double length, double edge);

}  // namespace haptogram::scattering
