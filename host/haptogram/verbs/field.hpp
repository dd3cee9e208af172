// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/acoustics/region.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/verbs/excitation.hpp"

namespace haptogram {

/// What is wanted of a sound field.
enum class Quantity {
    radiation,  ///< time-averaged radiation pressure on skin, Pa
    rms,        ///< sound pressure, Pa rms
    level,      ///< sound pressure level, dB re 20 µPa
    velocity,   ///< of the air's particles, m/s rms
    complex,    ///< pressure as complex amplitude, Pa; of one set of drives only
};

/// A quantity's short name, for options and menus, and what it is in words.
struct QuantityName {
    Quantity quantity;
    std::string_view name, about;
};
inline constexpr QuantityName quantity_names[] = {{Quantity::radiation, "radiation", "radiation pressure on skin"},
                                                  {Quantity::rms, "rms", "rms sound pressure"},
                                                  {Quantity::level, "spl", "sound pressure level"},
                                                  {Quantity::velocity, "velocity", "rms velocity of the particles"},
                                                  {Quantity::complex, "complex", "complex pressure"}};

/// @throws Error{bad_argument} naming those that there are
[[nodiscard]] Quantity quantity_of(std::string_view name);

/// A field over a region.
struct Field {
    Region region;
    std::string quantity;                   ///< its name in files, such as "radiation_pressure_pa"
    std::string label;                      ///< its name in pictures, such as "radiation pressure / Pa"
    std::vector<std::vector<float>> parts;  ///< one, or one a name; a value a point each
    std::vector<Vec3> marks;                ///< focal points that were asked for, metres
    std::string title;
    FieldMethod method = FieldMethod::sums;  ///< how it was computed
    /// How far the pressure, or the velocity, may be off: of the largest that the drives, with any phases, could make
    /// at any of the points.
    double error = 0.0;
    Quantity kind = Quantity::rms;
    std::vector<std::string> names{};  ///< of several parts, such as real and imag
};

/// The field of an excitation over a region.
/// @param threads  0: as many as there are processors; the result is the same, byte by byte, for any number
/// @throws Error{bad_argument} for a complex field of several sets of drives
[[nodiscard]] Field field(const Excitation& excitation, const Region& region, Quantity quantity, unsigned threads = 0,
                          const Progress& progress = {});

/// The pressure amplitude that an array can make at each point when it focuses there, Pa; NaN out of reach.
[[nodiscard]] Field workspace_field(const Array& array, const Region& region);

}  // namespace haptogram
