// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/scattering/dense.hpp"
#include "haptogram/scattering/kernel.hpp"
#include "haptogram/scattering/shells.hpp"

namespace haptogram::scattering {

/// The matrix of ½p − (K + βH)p, whose product with the pressures on the panels of a rigid body is p_in + β∂p_in/∂n of
/// the sound that comes in (Burton and Miller 1971). The pressure is constant on each panel, and the equation holds at
/// the panels' centres. Panels that lie close to a point are integrated on ever smaller parts of them; the integral of
/// H over a panel around its own centre is its finite part (Hadamard), which for a flat panel is one around its edge.
[[nodiscard]] DenseMatrix boundary_matrix(const Body& body, const Kernel& kernel);

}  // namespace haptogram::scattering
