// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <complex>
#include <span>
#include <vector>

#include "haptogram/array/array.hpp"

namespace haptogram {

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

}  // namespace haptogram
