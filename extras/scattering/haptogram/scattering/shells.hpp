// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/shape/shape.hpp"

namespace haptogram::scattering {

/// That the shells of a mesh, which are its connected parts, bound one body: none runs through another, and one inside
/// another faces the other way, as the wall of a hollow does. Otherwise some of the space would count twice.
/// @param mesh  closed, without repeated vertices
/// @throws Error{bad_input} naming "mesh", where it is, and what to do
void require_one_body(const Mesh& mesh);

}  // namespace haptogram::scattering
