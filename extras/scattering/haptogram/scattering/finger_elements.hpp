// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "haptogram/acoustics/finger_sound.hpp"

namespace haptogram::scattering {

/// The values of acoustics/finger_sound.hpp for one size, by boundary elements: a capsule of seven radii, whose other
/// end stands for the hand, in one plane wave a tilt.
/// @param size      wave number times radius
/// @param elements  triangles a wavelength
[[nodiscard]] FingerSound::Values finger_sound_by_elements(const FingerSound::Grid& grid, double size, double elements);

}  // namespace haptogram::scattering
