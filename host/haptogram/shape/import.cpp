// SPDX-License-Identifier: Apache-2.0
#include "haptogram/shape/import.hpp"

#include <fmt/core.h>

#include <string>
#include <system_error>
#include <utility>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/shape/formats.hpp"
#include "haptogram/shape/text.hpp"

namespace haptogram {
namespace {

Piece read_piece(std::string content, const std::string& format, const std::string& file) {
    if (format == "xyz") return read_xyz(content, file);
    if (format == "csv") return read_csv(content, file);
    if (format == "ply") return import_checked(check_ply(content, file), format, file);
    if (format == "obj") return import_checked(check_obj(content, file), format, file);
    return import_checked(check_stl(std::move(content), file), format, file);
}

}  // namespace

Shape load_shape(const std::filesystem::path& path, double metres_per_unit, std::string* content_sha256) {
    const std::string file = path.string();
    const std::string extension = lower_case(path.extension().string());
    std::error_code ignored;  // what else is wrong with the path, read_file says
    if (std::filesystem::is_directory(path, ignored)) throw bad_input(file, "is a directory; name a shape file in it");
    bool known = false;
    for (const char* const name : {".csv", ".obj", ".ply", ".stl", ".xyz"}) known = known || extension == name;
    if (!known)
        throw bad_input(
            file,
            fmt::format(
                "found the extension {}, expected .csv, .obj, .ply, .stl or .xyz; export the shape in one of these "
                "formats and name the file so",
                shown(extension)));
    std::string content = read_file(path);
    if (content_sha256 != nullptr) *content_sha256 = sha256(content);
    if (content.empty())
        throw bad_input(file, fmt::format("is empty, expected a shape in {} format; export it again", extension));
    Piece piece = read_piece(std::move(content), extension.substr(1), file);
    std::vector<Vec3>& points =
        std::holds_alternative<Mesh>(piece) ? std::get<Mesh>(piece).vertices : std::get<Cloud>(piece).points;
    for (Vec3& point : points) point = point * metres_per_unit;
    return {{std::move(piece)}};
}

}  // namespace haptogram
