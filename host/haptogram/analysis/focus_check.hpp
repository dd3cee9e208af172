// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>

#include "haptogram/model/array.hpp"

namespace haptogram {

/// What a set of drives makes of the focus it was asked for.
struct FocusCheck {
    double pressure_pa = 0.0;    ///< amplitude at the asked point
    double pressure_kept = 0.0;  ///< over that of exact phases and the same duty
    double peak_offset_m = 0.0;  ///< between the peak in the asked plane and that of exact phases
};

/// The point of largest pressure in the plane z = start.z, climbed to from `start` in shrinking steps; finds the peak
/// of the main lobe that `start` lies in, to a micrometre.
[[nodiscard]] Vec3 lateral_peak(const Array& array, std::span<const std::complex<double>> drives, Vec3 start);

/// @param drives  one an element, Pa·m
[[nodiscard]] FocusCheck check_focus(const Array& array, std::span<const std::complex<double>> drives, Vec3 focus);

}  // namespace haptogram
