// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptogram/acoustics/region.hpp"
#include "haptogram/base/progress.hpp"
#include "haptogram/verbs/focus_analysis.hpp"

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

/// @throws Error{bad_argument} when a path's ending is none of .csv, .npy, .vti, .png and .stl, or cannot show what is
/// to be written
void check_field_path(const std::string& path, const Region& region, Quantity quantity);

/// CSV: a column an axis in millimetres, of an oblique plane then x, y and z, and then the value.
[[nodiscard]] std::string to_csv(const Field& field);
/// NumPy's format 1.0: float32 or complex64, C order, axes (z, y, x) without those of one coordinate, or (v, u); and
/// behind them, of a probe, mean, least and greatest.
[[nodiscard]] std::string to_npy(const Field& field);
/// VTK image data in millimetres, for ParaView.
[[nodiscard]] std::string to_vti(const Field& field);

/// In words, how a field was computed, and how far it may be off.
[[nodiscard]] std::string description_of(const Field& field);

/// What a picture of it says in words and numbers, as JSON for tools/plot_field.py. Marks are in the region's own
/// coordinates.
[[nodiscard]] std::string about(const Field& field);

/// Writes the field in the format that the path's ending names; standard output ("-"), devices and pipes get CSV. A
/// picture is drawn by python3 with matplotlib, which must be there. An .stl file is of the surface so many decibels
/// below the greatest value.
/// @return in words, what the surface is; empty for the other files
/// @throws Error{bad_input} when it cannot be written
std::string write_field(const std::string& path, const Field& field, double below_db = 6.0);

/// A flat patch of points in any direction. Point (i, j) is origin + u·i/(width − 1) + v·j/(height − 1).
struct Slice {
    Vec3 origin;                          ///< a corner, metres
    Vec3 u, v;                            ///< the edges that begin there, metres
    std::uint32_t width = 0, height = 0;  ///< points along u and along v

    [[nodiscard]] std::size_t size() const { return std::size_t{width} * height; }
};

inline constexpr std::uint32_t most_slice_points = 2048;  ///< along an edge
inline constexpr std::size_t most_skin_points = 20'000;   ///< places on a skin, or anywhere else
inline constexpr double most_slice_terms = 1e10;          ///< elements × sets of drives × points

/// Mean square of the sound pressure at a slice's points, Pa²: rows along u, v = 0 first. Radiation pressure, rms
/// pressure and level follow from it by a factor or a logarithm, so that a view changes its unit without a new
/// calculation. The same numbers as field() gives for Quantity::rms, squared. Slices along the axes are the fastest.
/// @param threads  0: as many as there are processors; the result is the same, byte by byte, for any number
/// @throws Error{bad_argument} for a slice that has fewer than 2 or more than most_slice_points along an edge, whose
/// corner or edges are not finite, or that takes more than most_slice_terms; and as mean_square_pressure_at()
[[nodiscard]] std::vector<float> mean_square_on(const Excitation& excitation, const Slice& slice, unsigned threads = 1,
                                                const Progress& progress = {});

/// The same at places anywhere, one to most_skin_points.
[[nodiscard]] std::vector<float> mean_square_at(const Excitation& excitation, std::span<const Vec3> points);

/// The same of a focus that the array makes at each point in turn: what it can do where. 0 out of its reach.
/// @throws Error as mean_square_on(), of one set of drives
[[nodiscard]] std::vector<float> reachable_on(const Array& array, const Slice& slice);

}  // namespace haptogram
