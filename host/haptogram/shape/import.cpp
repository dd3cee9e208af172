// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/import.hpp"

#include <fmt/core.h>

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

Piece read_piece(std::string_view content, ShapeFormat format, const std::string& name) {
    switch (format) {
        case ShapeFormat::csv: return read_csv(content, name);
        case ShapeFormat::obj: return as_piece(read_obj(content, name), name);
        case ShapeFormat::ply: return as_piece(read_ply(content, name), name);
        case ShapeFormat::stl: return as_piece(read_stl(content, name), name);
        case ShapeFormat::xyz: return read_xyz(content, name);
    }
    throw bad_argument("format", "is none of the shape formats; choose one of ShapeFormat");
}

}  // namespace

ShapeFormat shape_format(const std::string& file_name) {
    constexpr std::array<std::pair<std::string_view, ShapeFormat>, 5> formats{{{".csv", ShapeFormat::csv},
                                                                               {".obj", ShapeFormat::obj},
                                                                               {".ply", ShapeFormat::ply},
                                                                               {".stl", ShapeFormat::stl},
                                                                               {".xyz", ShapeFormat::xyz}}};
    const std::string extension = ending_of(file_name);
    for (const auto& [known, format] : formats)
        if (extension == known) return format;
    throw bad_input(
        file_name,
        fmt::format("found the extension {}, expected .csv, .obj, .ply, .stl or .xyz; export the shape in one of these "
                    "formats and name the file so",
                    shown(extension)));
}

Shape load_shape(std::string_view content, ShapeFormat format, const std::string& name, double metres_per_unit) {
    if (!(metres_per_unit > 0.0) || !std::isfinite(metres_per_unit))
        throw bad_argument("metres_per_unit",
                           fmt::format("found {}, expected a positive number; correct it", metres_per_unit));
    if (content.empty()) throw bad_input(name, "is empty, expected a shape; export it again");
    Piece piece = read_piece(content, format, name);
    std::vector<Vec3>& points =
        std::holds_alternative<Mesh>(piece) ? std::get<Mesh>(piece).vertices : std::get<Cloud>(piece).points;
    for (Vec3& point : points) point = point * metres_per_unit;
    Shape shape;
    shape.pieces.push_back(std::move(piece));
    return shape;
}

Shape load_shape(const std::filesystem::path& path, double metres_per_unit, std::string* content_sha256) {
    const std::string name = path.string();
    std::error_code ignored;  // what else is wrong with the path, read_file says
    if (std::filesystem::is_directory(path, ignored)) throw bad_input(name, "is a directory; name a shape file in it");
    const ShapeFormat format = shape_format(name);
    const std::string content = read_file(path);
    const std::string begin = lower_case(std::string_view(content).substr(0, 200));
    const std::size_t first = begin.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    if (first != std::string::npos &&
        (begin.compare(first, 9, "<!doctype") == 0 || begin.compare(first, 5, "<html") == 0))
        throw bad_input(name,
                        "found a web page (HTML), expected a shape; download the file itself, not the page about it");
    if (content_sha256 != nullptr) *content_sha256 = sha256(content);
    return load_shape(content, format, name, metres_per_unit);
}

}  // namespace haptogram
