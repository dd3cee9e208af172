// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/acoustics/drive_sequence.hpp"
#include "haptogram/array/array.hpp"

namespace haptogram {

/// Diameter of the skin that a force is of unless told otherwise: the papers do not say on what area they measured.
inline constexpr double default_contact_m = 0.02;
inline constexpr double widest_contact_m = 0.2;  ///< as long as a hand

/// A place on the skin.
struct SkinPlace {
    Vec3 position;                ///< metres, array frame
    Vec3 normal{0.0, 0.0, -1.0};  ///< out of the skin; a palm that faces the array
};

/// What a place feels over time: the local modulation.
struct SkinForce {
    std::vector<double> pressure_pa;  ///< radiation pressure at the place, one value a carrier period
    std::vector<double> force_n;      ///< at right angles to the skin, on a flat disc around the place
    double tilt = 0.0;  ///< cos²θ between the sound's way from the array's centre and the normal; 0: it faces away
};

/// Radiation pressure and force of a sequence on flat, rigid skin (acoustics/skin_pressure.hpp), with the transducers'
/// bandwidth. The disc is integrated by disc_nodes() (acoustics/disc.hpp).
/// @param diameter_m  of the disc
/// @throws Error{bad_argument} for places that are not finite, normals without direction and diameters that are not
/// positive or beyond the widest; Error{bad_input} for a place at an element, or a sequence of nothing
[[nodiscard]] SkinForce force_on_skin(const Array& array, const DriveSequence& sequence, const SkinPlace& place,
                                      double diameter_m = default_contact_m);

/// The force of drives that do not change, on a disc of that default which faces the array, N.
[[nodiscard]] double steady_force(const Array& array, std::span<const std::complex<double>> drives, Vec3 place);

/// The force of a focus with exact phases and full, steady drive (steady_force()), N.
/// @throws Error{bad_input} naming "focus" when the array cannot reach it
[[nodiscard]] double full_force(const Array& array, Vec3 focus);

/// (largest − least)/(largest + least) of a signal that is not negative: 1 when it falls to 0, 0 when it is steady or
/// silent.
[[nodiscard]] double modulation_depth(const std::vector<double>& signal);

}  // namespace haptogram
