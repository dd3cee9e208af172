// SPDX-License-Identifier: Apache-2.0
// Formats of shapes that the core does not read: extras/formats does. Who opens shapes passes its readers in.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace haptogram {

struct Polygons;

enum class ShapeFormat { csv, gltf, obj, off, pcd, ply, stl, svg, three_mf, xyz };

/// A file that is open.
struct ShapeFile {
    std::string_view content;
    std::string name;  ///< for messages
    bool on_disk;      ///< `name` is its path, and it may name files beside it; otherwise it may name none
};

/// As the readers of formats.hpp. @throws Error{bad_input}
using ShapeReaders = std::map<ShapeFormat, std::function<Polygons(const ShapeFile& file)>>;

}  // namespace haptogram
