// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/import.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/text.hpp"
#include "haptogram/shape/formats.hpp"

namespace haptogram {
namespace {

Polygons read(const ShapeFile& file, ShapeFormat format, const ShapeReaders& readers) {
    const auto& [content, name, on_disk] = file;
    switch (format) {
        case ShapeFormat::csv: return read_rows(content, name, true);
        case ShapeFormat::obj: return read_obj(content, name);
        case ShapeFormat::ply: return read_ply(content, name);
        case ShapeFormat::stl: return read_stl(content, name);
        case ShapeFormat::xyz: return read_rows(content, name, false);
        default: break;
    }
    if (const auto found = readers.find(format); found != readers.end()) return found->second(file);
    throw bad_argument(name,
                       "the extra formats reads such files, and this build leaves it out; build with "
                       "-DHAPTOGRAM_EXTRAS=all, or export the shape as .ply, .stl, .obj or .csv");
}

/// The beginning of a text, in small letters, without what is blank before it.
std::string first_words(std::string_view content) {
    const std::string begin = lower_case(content.substr(0, 200));
    const std::size_t first = begin.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    return first == std::string::npos ? "" : begin.substr(first);
}

bool is_binary_stl(std::string_view content) {
    constexpr std::size_t header = 80, count = 4, facet = 50;
    if (content.size() < header + count) return false;
    std::size_t facets = 0;
    for (std::size_t i = 0; i < count; ++i)
        facets |= std::size_t{static_cast<unsigned char>(content[header + i])} << (8 * i);
    return content.size() == header + count + facets * facet;
}

/// Whether a line of the text begins with the word "v", as those of an OBJ file's vertices do.
bool has_vertices_of_obj(std::string_view content) {
    return content.starts_with("v ") || content.find("\nv ") != std::string_view::npos;
}

}  // namespace

ShapeFormat shape_format(std::string_view content, const std::string& name) {
    if (content.empty()) throw bad_input(name, "is empty, expected a shape; export it again");
    const std::string begin = first_words(content);
    if (begin.starts_with("ply")) return ShapeFormat::ply;
    if (begin.starts_with("off") || begin.starts_with("coff")) return ShapeFormat::off;
    if (content.starts_with("PK\3\4")) return ShapeFormat::three_mf;
    if (content.starts_with("glTF") || begin.starts_with('{')) return ShapeFormat::gltf;
    if (begin.starts_with("# .pcd") || begin.starts_with("version")) return ShapeFormat::pcd;
    if (begin.starts_with("<svg") || begin.starts_with("<?xml")) return ShapeFormat::svg;
    if (is_binary_stl(content) || begin.starts_with("solid")) return ShapeFormat::stl;
    if (has_vertices_of_obj(content)) return ShapeFormat::obj;
    if (begin.find(',') != std::string::npos || begin.starts_with('x')) return ShapeFormat::csv;
    if (begin.find_first_of("0123456789#") != std::string::npos) return ShapeFormat::xyz;
    throw bad_input(
        name,
        "found nothing that begins as a shape's file does, such as PLY, STL, OBJ or CSV; save it as a file and "
        "name that");
}

bool has_y_up_by_habit(std::string_view obj) {
    for (Lines lines(obj.substr(0, 2000)); lines.next();)
        for (const std::string_view program : {"Blender", "Maya"})
            if (lines.line().starts_with('#') && lines.line().find(program) != std::string_view::npos) return true;
    return false;
}

Shape stood_up(Shape shape) {
    const auto upright = [](Vec3 p) { return Vec3{p.x, -p.z, p.y}; };
    const auto stand = [upright](std::vector<Vec3>& points) {
        std::ranges::transform(points, points.begin(), upright);
    };
    for (Piece& piece : shape.pieces) {
        if (auto* const mesh = std::get_if<Mesh>(&piece)) stand(mesh->vertices);
        if (auto* const cloud = std::get_if<Cloud>(&piece)) stand(cloud->points);
        if (auto* const curve = std::get_if<Curve>(&piece))
            curve->at = [at = curve->at, upright](double s) { return upright(at(s)); };
    }
    return shape;
}

namespace {

constexpr std::array<std::pair<std::string_view, ShapeFormat>, 11> endings{{{".3mf", ShapeFormat::three_mf},
                                                                            {".csv", ShapeFormat::csv},
                                                                            {".glb", ShapeFormat::gltf},
                                                                            {".gltf", ShapeFormat::gltf},
                                                                            {".obj", ShapeFormat::obj},
                                                                            {".off", ShapeFormat::off},
                                                                            {".pcd", ShapeFormat::pcd},
                                                                            {".ply", ShapeFormat::ply},
                                                                            {".stl", ShapeFormat::stl},
                                                                            {".svg", ShapeFormat::svg},
                                                                            {".xyz", ShapeFormat::xyz}}};

}  // namespace

bool has_shape_ending(const std::string& file_name) {
    return std::ranges::find(endings, ending_of(file_name), &std::pair<std::string_view, ShapeFormat>::first) !=
           endings.end();
}

ShapeFormat shape_format(const std::string& file_name) {
    const std::string extension = ending_of(file_name);
    for (const auto& [known, format] : endings)
        if (extension == known) return format;
    if (extension == ".hex") throw bad_input(file_name, "is an image, compiled already; upload, inspect or feel it");
    throw bad_input(file_name,
                    fmt::format("found the extension {}, expected .3mf, .csv, .glb, .gltf, .obj, .off, .pcd, .ply, "
                                ".stl, .svg or .xyz; export the shape in one of these formats and name the file so",
                                shown(extension)));
}

Shape load_shape(const ShapeFile& file, ShapeFormat format, double metres_per_unit, const ShapeReaders& readers) {
    const auto& [content, name, on_disk] = file;
    if (!(metres_per_unit > 0.0) || !std::isfinite(metres_per_unit))
        throw bad_argument("metres_per_unit",
                           fmt::format("found {}, expected a positive number; correct it", metres_per_unit));
    if (content.empty()) throw bad_input(name, "is empty, expected a shape; export it again");
    if (const std::string begin = first_words(content); begin.starts_with("<!doctype") || begin.starts_with("<html"))
        throw bad_input(name,
                        "found a web page (HTML), expected a shape; download the file itself, not the page about it");
    Polygons polygons =
        read({is_binary_stl(content) ? content : without_byte_order_mark(content), name, on_disk}, format, readers);
    if (polygons.own_unit_m && metres_per_unit != millimetre)
        throw bad_input(name,
                        fmt::format("it says its unit itself, {:g} mm, and takes no other; leave the unit out, and use "
                                    "the scale for a file that is wrong",
                                    *polygons.own_unit_m / millimetre),
                        {"unit"});
    for (Vec3& vertex : polygons.vertices) vertex = vertex * polygons.own_unit_m.value_or(metres_per_unit);
    return as_shape(std::move(polygons), name);
}

Shape load_shape(const std::filesystem::path& path, double metres_per_unit, const ShapeReaders& readers) {
    const std::string name = path.string();
    std::error_code ignored;  // what else is wrong with the path, read_file says
    if (std::filesystem::is_directory(path, ignored)) throw bad_input(name, "is a directory; name a shape file in it");
    const ShapeFormat format = shape_format(name);
    return load_shape({read_file(path), name, true}, format, metres_per_unit, readers);
}

}  // namespace haptogram
