// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>

#include "haptogram/array/vec3.hpp"

namespace haptogram {

/// Millimetres for a file that read back as the same metres, whenever there are such.
[[nodiscard]] inline double exact_mm(double metres) {
    const double millimetres = metres / millimetre;
    double below = millimetres, above = millimetres;
    for (int i = 0; i < 3; ++i) {  // dividing and multiplying round by no more than two steps
        if (below * millimetre == metres) return below;
        if (above * millimetre == metres) return above;
        below = std::nextafter(below, -INFINITY);
        above = std::nextafter(above, INFINITY);
    }
    return millimetres;
}

}  // namespace haptogram
