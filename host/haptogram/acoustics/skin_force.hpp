// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/acoustics/drive.hpp"
#include "haptogram/array/array.hpp"

namespace haptogram {

/// A node of a quadrature over a disc: where it lies from the disc's centre, metres, and its share of the area.
struct DiscNode {
    double x = 0.0, y = 0.0, weight = 0.0;
};

/// Gauss-Legendre quadrature along the radius and the trapezoidal rule around, with as many nodes as squares of a sound
/// of this wavelength need: their mean is off by less than 2e-5, whatever the directions that it comes from.
[[nodiscard]] std::vector<DiscNode> disc_nodes(double diameter_m, double wavelength_m);

/// The sound that arrives at a small flat patch of skin, Pa: the pressure that it would have without the skin, and
/// the parts of it that graze the skin, Σ p·sin θ·t in two directions t along the skin. θ is the angle between a
/// wave's way and the skin's normal. Sums of these are sums of sounds.
struct PatchSound {
    std::complex<double> pressure, along, across;
    PatchSound& operator+=(const PatchSound& other) {
        pressure += other.pressure;
        along += other.along;
        across += other.across;
        return *this;
    }
    friend PatchSound operator+(PatchSound a, const PatchSound& b) { return a += b; }
    friend PatchSound operator-(const PatchSound& a, const PatchSound& b) {
        return {a.pressure - b.pressure, a.along - b.along, a.across - b.across};
    }
    friend PatchSound operator*(double factor, const PatchSound& a) {
        return {factor * a.pressure, factor * a.along, factor * a.across};
    }
};

/// Time-averaged radiation pressure at right angles to a patch of rigid, flat skin, Pa:
/// (|Σ p|² − |Σ p·sin θ·t|²)/(ρc²). The skin doubles the pressure and the velocity along it, and the pressure on it is
/// that of the potential energy less that of the kinetic energy. One plane wave gives 2E·cos²θ with its energy density
/// E, which at θ = 0 is the radiation pressure of Hoshi et al. 2010 (eq. 1) with α = 2. Waves that come in evenly from
/// all sides lose nothing, because their velocities along the skin cancel.
[[nodiscard]] double radiation_pressure(const PatchSound& sound, const Medium& medium);

/// What each element sends to a patch of skin with a drive of 1 Pa·m, 1/m, one an element. The waves are plane over
/// the patch: it must be far from every element beside the wavelength. What comes from behind the skin is left out: the
/// hand is in its way.
/// @param normal  out of the skin, of any length but 0
/// @throws Error{bad_argument} naming "normal" when it has no direction, and Error{bad_input} when the point coincides
/// with an element
[[nodiscard]] std::vector<PatchSound> waves_at_patch(const Array& array, Vec3 point, Vec3 normal);

/// The sum over the elements. @param drives  one an element, Pa·m
[[nodiscard]] PatchSound sound_at_patch(std::span<const PatchSound> waves,
                                        std::span<const std::complex<double>> drives);

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

/// Radiation pressure and force of a sequence on flat, rigid skin (acoustics/skin_force.hpp), with the transducers'
/// bandwidth. The disc is integrated by disc_nodes() (acoustics/skin_force.hpp).
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
