// SPDX-License-Identifier: Apache-2.0
#include "haptogram/acoustics/disc.hpp"

#include <cmath>
#include <numbers>

namespace haptogram {

std::vector<DiscNode> disc_nodes(double diameter_m, double wavelength_m) {
    const unsigned rings = 3 + static_cast<unsigned>(std::ceil(1.2 * diameter_m / wavelength_m));
    const unsigned around = 4 * (rings - 1);
    std::vector<DiscNode> nodes;
    for (unsigned i = 0; i < rings; ++i) {
        // Newton's method finds the roots of the Legendre polynomial P; P' = n·(x·P − P₋₁)/(x² − 1).
        double root = std::cos(std::numbers::pi * (i + 0.75) / (rings + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; ++step) {
            const double value = std::legendre(rings, root);
            slope = rings * (root * value - std::legendre(rings - 1, root)) / (root * root - 1.0);
            root -= value / slope;
        }
        const double part = (1.0 + root) / 2.0;  // of the radius; the area grows with 2·part
        const double weight = 2.0 * part / ((1.0 - root * root) * slope * slope) / around;
        for (unsigned j = 0; j < around; ++j) {
            const double angle = 2.0 * std::numbers::pi * (j + 0.5 * (i % 2)) / around, r = diameter_m / 2.0 * part;
            nodes.push_back({r * std::cos(angle), r * std::sin(angle), weight});
        }
    }
    return nodes;
}

}  // namespace haptogram
