// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

namespace haptogram {

/// A node of a quadrature over a disc: where it lies from the disc's centre, metres, and its share of the area.
struct DiscNode {
    double x = 0.0, y = 0.0, weight = 0.0;
};

/// Gauss-Legendre quadrature along the radius and the trapezoidal rule around, with as many nodes as squares of a sound
/// of this wavelength need: their mean is off by less than 2e-5, whatever the directions that it comes from.
[[nodiscard]] std::vector<DiscNode> disc_nodes(double diameter_m, double wavelength_m);

}  // namespace haptogram
