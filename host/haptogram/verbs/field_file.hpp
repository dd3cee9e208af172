// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "haptogram/verbs/field.hpp"

namespace haptogram {

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

}  // namespace haptogram
