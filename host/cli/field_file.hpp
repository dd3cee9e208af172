// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "haptogram/acoustics/region.hpp"

namespace haptogram::cli {

/// A field over a region, to be written.
struct FieldFile {
    Region region;
    std::string quantity;                   ///< as a column and an array are called, such as "radiation_pressure_pa"
    std::string label;                      ///< as an axis is, such as "radiation pressure / Pa"
    std::vector<std::vector<float>> parts;  ///< one, or the real and the imaginary part; a value a point each
    std::vector<Vec3> marks;                ///< focal points that were asked for, metres
    std::string title;
};

/// @throws Error{bad_argument} when a path's ending is none of .csv, .npy, .vti, .png, or cannot show what is to be
/// written
void check_field_path(const std::string& path, const Region& region, bool complex_values);

/// Writes it as the ending says; "-" and paths that are no files get CSV. A picture is drawn by matplotlib.
/// @throws Error{bad_input} when it cannot be written
void write_field(const std::string& path, const FieldFile& field);

}  // namespace haptogram::cli
