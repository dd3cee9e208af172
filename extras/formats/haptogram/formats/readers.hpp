// SPDX-License-Identifier: Apache-2.0
// Further formats of shapes. Each reader takes a whole file and makes of it what shape/formats.hpp does, with its
// errors.
#pragma once
#include <functional>
#include <optional>
#include <string>

#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/readers.hpp"

namespace haptogram::formats {

/// Meshes and clouds as text, without colours.
[[nodiscard]] Polygons read_off(const ShapeFile& file);
/// Clouds of the Point Cloud Library, in the file's unit. Points of NaN are unseen pixels.
[[nodiscard]] Polygons read_pcd(const ShapeFile& file);
/// What a 3MF file builds: meshes of objects and their components, each at its place.
[[nodiscard]] Polygons read_three_mf(const ShapeFile& file);
/// The same, unpacked. @param part  the content of a file in it, if there is one
using Parts = std::function<std::optional<std::string>(const std::string& part)>;
[[nodiscard]] Polygons read_three_mf_parts(const Parts& part, const std::string& name);
/// The default scene of a glTF or GLB file, in metres, with y upwards as the file has it.
[[nodiscard]] Polygons read_gltf(const ShapeFile& file);
/// The outlines of a drawing, as curves in the plane z = 0, with y upwards.
[[nodiscard]] Polygons read_svg(const ShapeFile& file);

/// All of these.
[[nodiscard]] inline ShapeReaders readers() {
    return {{ShapeFormat::off, read_off},
            {ShapeFormat::pcd, read_pcd},
            {ShapeFormat::three_mf, read_three_mf},
            {ShapeFormat::gltf, read_gltf},
            {ShapeFormat::svg, read_svg}};
}

}  // namespace haptogram::formats
