// SPDX-License-Identifier: Apache-2.0
#include "haptogram/verbs/field_file.hpp"

#include <fmt/format.h>

#include <bit>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>

#include "haptogram/base/error.hpp"
#include "haptogram/base/file.hpp"
#include "haptogram/base/picture.hpp"
#include "haptogram/verbs/iso_surface.hpp"

namespace haptogram {
namespace {

static_assert(std::endian::native == std::endian::little, "the files say little-endian");

const std::vector<double>& axis_of(const Grid& grid, char axis) {
    return axis == 'x' || axis == 'u' ? grid.x : axis == 'y' || axis == 'v' ? grid.y : grid.z;
}

double along(Vec3 point, char axis) {
    return axis == 'x' || axis == 'u' ? point.x : axis == 'y' || axis == 'v' ? point.y : point.z;
}

/// VTK's attribute for images that are turned: a matrix row by row, whose columns are the image's axes.
std::string direction_of(const Pose& pose) {
    const auto& [o, x, y, z] = pose;
    return fmt::format(" Direction=\"{:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g}\"", x.x,
                       y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z);
}

std::string name_of(const Field& field, std::size_t part) {
    return field.names.empty() ? field.quantity : fmt::format("{}_{}", field.quantity, field.names[part]);
}

/// The one value of a point that a picture or a surface shows: of several readings the greatest.
Field shown(Field field) {
    if (field.parts.size() > 1) field.parts = {field.parts.back()};
    return field;
}

template <class Value>
void append(std::string& bytes, const Value& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string to_csv(const Field& field) {
    fmt::memory_buffer text;
    for (const char axis : field.region.axes) fmt::format_to(std::back_inserter(text), "{}_mm,", axis);
    if (field.region.pose) fmt::format_to(std::back_inserter(text), "x_mm,y_mm,z_mm,");
    for (std::size_t part = 0; part < field.parts.size(); ++part)
        fmt::format_to(std::back_inserter(text), "{}{}", part == 0 ? "" : ",", name_of(field, part));
    text.push_back('\n');
    for (std::size_t i = 0; i < field.region.grid.size(); ++i) {
        for (const char axis : field.region.axes)
            fmt::format_to(std::back_inserter(text), "{:.4f},", along(field.region.grid.point(i), axis) / millimetre);
        if (field.region.pose) {
            const Vec3 p = field.region.point(i);
            fmt::format_to(std::back_inserter(text), "{:.4f},{:.4f},{:.4f},", p.x / millimetre, p.y / millimetre,
                           p.z / millimetre);
        }
        for (std::size_t part = 0; part < field.parts.size(); ++part)
            fmt::format_to(std::back_inserter(text), "{}{:.6g}", part == 0 ? "" : ",", field.parts[part][i]);
        text.push_back('\n');
    }
    return fmt::to_string(text);
}

std::string to_npy(const Field& field) {
    std::string shape;
    for (auto axis = field.region.axes.rbegin(); axis != field.region.axes.rend(); ++axis)
        shape += fmt::format("{},", axis_of(field.region.grid, *axis).size());
    if (field.parts.size() > 2) shape += fmt::format("{},", field.parts.size());
    std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}",
                                     field.parts.size() == 2 ? "<c8" : "<f4", shape);
    constexpr std::size_t before = 10;
    header.append(63 - (before + header.size()) % 64, ' ');
    header += '\n';
    std::string bytes("\x93NUMPY\x01\x00", 8);
    append(bytes, static_cast<std::uint16_t>(header.size()));
    bytes += header;
    bytes.reserve(bytes.size() + field.parts.size() * field.parts.front().size() * sizeof(float));
    for (std::size_t i = 0; i < field.parts.front().size(); ++i)
        for (const auto& part : field.parts) append(bytes, part[i]);
    return bytes;
}

std::string to_vti(const Field& field) {
    const Grid& grid = field.region.grid;
    const auto spacing = [](const std::vector<double>& axis) {
        return axis.size() < 2 ? 1.0 : (axis.back() - axis.front()) / static_cast<double>(axis.size() - 1) / millimetre;
    };
    const std::string extent = fmt::format("0 {} 0 {} 0 {}", grid.x.size() - 1, grid.y.size() - 1, grid.z.size() - 1);
    const Vec3 origin = field.region.point(0);
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<ImageData WholeExtent=\"{0}\" Origin=\"{1:.9g} {2:.9g} {3:.9g}\" "
        "Spacing=\"{4:.9g} {5:.9g} {6:.9g}\"{8}>\n<Piece Extent=\"{0}\">\n<PointData Scalars=\"{7}\">\n",
        extent, origin.x / millimetre, origin.y / millimetre, origin.z / millimetre, spacing(grid.x), spacing(grid.y),
        spacing(grid.z), field.quantity, field.region.pose ? direction_of(*field.region.pose) : std::string());
    const std::uint64_t bytes = field.parts.front().size() * sizeof(float);
    for (std::size_t part = 0; part < field.parts.size(); ++part)
        text += fmt::format("<DataArray type=\"Float32\" Name=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                            name_of(field, part), part * (bytes + sizeof bytes));
    text += "</PointData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_";
    for (const auto& part : field.parts) {
        append(text, bytes);
        text.append(reinterpret_cast<const char*>(part.data()), bytes);
    }
    return text + "\n</AppendedData>\n</VTKFile>\n";
}

std::string about(const Field& field) {
    nlohmann::json about = {{"axes", field.region.axes},
                            {"region", field.region.text},
                            {"label", field.label},
                            {"title", field.title},
                            {"marks_mm", nlohmann::json::array()}};
    for (const char axis : field.region.axes) {
        auto& values = about[fmt::format("{}_mm", axis)];
        for (const double value : axis_of(field.region.grid, axis)) values.push_back(value / millimetre);
    }
    for (const Vec3& mark : field.marks) {
        const Vec3 p = field.region.pose ? field.region.pose->inwards(mark) : mark;
        about["marks_mm"].push_back({p.x / millimetre, p.y / millimetre, p.z / millimetre});
    }
    return about.dump();
}

namespace {

void draw(const std::string& path, const Field& field) {
    Picture picture("shipped:tools/plot_field.py");
    picture.add("field.npy", to_npy(field));
    picture.add("about.json", about(field));
    picture.draw(path, ".csv, .npy and .vti");
}

}  // namespace

void check_field_path(const std::string& path, const Region& region, Quantity quantity) {
    const std::string kind = ending_of(path);
    if (!kind.empty() && kind != ".csv" && kind != ".npy" && kind != ".vti" && kind != ".png" && kind != ".stl")
        throw bad_argument(
            "output",
            fmt::format("'{}' is no ending that is known; .csv, .npy, .vti, .png and .stl are, and none means CSV",
                        kind));
    if (kind == ".stl" && (region.axes.size() != 3 || quantity == Quantity::complex))
        throw bad_argument("output",
                           "a .stl file holds the surface of one value in a volume; take a volume and a real quantity");
    if (kind == ".png" && (region.axes.size() == 3 || (quantity == Quantity::complex)))
        throw bad_argument(
            "output",
            fmt::format("{} has no picture; take a plane or a line and a real quantity, or a .vti file for ParaView",
                        (quantity == Quantity::complex) ? "a complex field" : "a volume"));
}

std::string description_of(const Field& field) {
    return fmt::format("{} points by {}, off by at most {:.1g} of the largest {} that the drives could make",
                       field.region.grid.size(),
                       field.method == FieldMethod::interpolated ? "interpolation"
                       : field.method == FieldMethod::shifts     ? "shifted copies of one element's field"
                                                                 : "sums of all waves",
                       field.error, field.kind == Quantity::velocity ? "velocity" : "pressure");
}

std::string write_field(const std::string& path, const Field& field, double below_db) {
    const std::string kind = ending_of(path);
    if (kind == ".png") {
        draw(path, shown(field));
    } else if (kind == ".stl") {
        const IsoSurface surface = surface_below(shown(field), below_db);
        write_file(path, to_stl(surface));
        return description_of(surface);
    } else {
        write_file(path, kind == ".npy" ? to_npy(field) : kind == ".vti" ? to_vti(field) : to_csv(field));
    }
    return {};
}

}  // namespace haptogram
